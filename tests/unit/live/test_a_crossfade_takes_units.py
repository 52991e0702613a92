"""How long a crossfade takes, and where it stands, is written in any unit that they can have."""

from __future__ import annotations

import pytest

from cosim.base.errors import InputError
from cosim.master.assembly.assemble import put_together
from cosim.master.components.participant import setup_of
from cosim.reading import load


def parameters(value: str) -> dict[str, object]:
    scenario = load("two_users_box_switched", sets=[f"components.fade_a.parameters.{value}"])
    return dict(setup_of(scenario, put_together(scenario).participants["fade_a"]).parameters)


@pytest.mark.parametrize(
    ("value", "meant"),
    [
        ("fade_time=20 ms", ("fade_time", 0.02)),
        ("fade_time=0.25", ("fade_time", 0.25)),
        ("position=50 %", ("position", 0.5)),
        ("position=1", ("position", 1.0)),
    ],
)
def test_a_value_is_in_the_unit_of_its_parameter(value: str, meant: tuple[str, float]) -> None:
    assert parameters(value)[meant[0]] == meant[1]


@pytest.mark.parametrize(
    ("value", "why"),
    [
        ("position=5 mm", "mm, which does not convert to 1"),
        ("fade_time=5 mm", "mm, which does not convert to s"),
        ("position=1.5", "the most that it can be is 1"),
    ],
)
def test_another_quantity_is_refused(value: str, why: str) -> None:
    with pytest.raises(InputError, match=f"fade_a.*{why}"):
        parameters(value)
