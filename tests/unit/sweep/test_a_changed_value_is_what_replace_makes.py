"""The quick way to another scenario or component gives what ``dataclasses.replace`` does."""

from __future__ import annotations

from dataclasses import fields, replace

import pytest

from cosim.base.changed import changed
from cosim.master.assembly.assemble import Assembly
from cosim.master.components.participant import Participant
from cosim.scenario import Scenario, ScenarioComponent, load


@pytest.mark.parametrize("kind", [Scenario, ScenarioComponent, Participant, Assembly])
def test_nothing_is_computed_when_one_is_made(kind: type) -> None:
    """Else ``changed`` would leave it out."""
    assert not hasattr(kind, "__post_init__")
    assert not hasattr(kind, "__slots__")
    assert all(each.init for each in fields(kind))


def test_it_is_what_replace_makes() -> None:
    scenario = load("two_users_box")
    before = scenario.seed
    other = changed(scenario, seed=before + 1, title="another")
    assert other == replace(scenario, seed=before + 1, title="another")
    assert other.root is scenario.root
    assert (scenario.seed, other.seed) == (before, before + 1)


def test_a_member_that_there_is_not_is_refused() -> None:
    with pytest.raises(TypeError, match="Scenario has no sede"):
        changed(load("two_users_box"), sede=7)
