"""A coupler with a computation delay gives the same bits without feedthrough, so no loop."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.master.master_support import run, scenario_of

NAMES = ("h.position", "o.velocity", "k.force")


def pushed(delay: int, *, feedthrough: bool) -> dict[str, Any]:
    gains = {"stiffness": 500, "damping": 2, "computation_delay_ticks": delay}
    return {
        "duration": 0.5,
        "components": {
            "s": {"fmu": "signal", "rate": 1024, "parameters": {"mode": "sine", "frequency": 2.0}},
            "h": {"fmu": "hand", "rate": 1024},
            "o": {"fmu": "object", "rate": 1024},
            "k": {"fmu": "virtual_coupler", "rate": 1024, "parameters": gains}
            | {"feedthrough": feedthrough},
        },
        "connections": [
            "s.value -> h.force",
            *(f"{body}.position -> k.position_{end}" for body, end in (("h", "a"), ("o", "b"))),
            *(f"{body}.velocity -> k.velocity_{end}" for body, end in (("h", "a"), ("o", "b"))),
            "k.force -> o.force[1]",
            "k.reaction -> h.coupler_force",
        ],
    }


@pytest.mark.parametrize("delay", [0, 1, 3])
def test_the_bits_are_the_same_from_a_delay_of_one_tick_on(tmp_path: Path, delay: int) -> None:
    both = [run(scenario_of(tmp_path, pushed(delay, feedthrough=f)))[0] for f in (True, False)]
    same = [np.array_equal(both[0].signal(name), both[1].signal(name)) for name in NAMES]
    assert all(same) is (delay > 0)
    assert np.abs(both[0].signal("k.force")).max() > 0.01
