"""Delay and stiffness, both architectures: simulated runs calm down where the theory says so.

Cells that the boundary crosses may go either way, and their neighbours: a run is finite.
"""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

from cosim.reading import FORMS
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.sweep import run_sweep
from cosim.sweep.theory import is_stable

MAPS: dict[str, tuple[list[str], str, str]] = {
    "distributed": (["coupler_12.stiffness", "coupler_21.stiffness"], "50..4000", "coupler_11"),
    "centralized": (["coupler_2.stiffness"], "20..1500", "coupler_2"),
}
"""What is stiff, how stiff, and whose force is looked at."""
PUSH = ["components.step_1.parameters.duration=0.2"]
"""A push that ends: what is left is the loop's own movement."""


def maps(
    architecture: str, shape: tuple[int, int], seconds: int, out: Path, workers: int
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Where runs calm down, and where the theory says that they do: (delays, stiffnesses)."""
    places, span, coupler = MAPS[architecture]
    stiffness = {"set": places, "values": f"{span}/{shape[1]} log"}
    expected: dict[str, Any] = {f"{coupler}.force": {"growth_below": 0, "from": 0.5}}
    request = Request(
        scenario=f"single_axis_{architecture}",
        vary={"lan.round_trip_delay": f"0..{shape[0] - 1}", "k": stiffness},
        sets=[f"duration={seconds} s", *PUSH],
        expect=expected,
        check_every=0,
    )
    outcome = run_sweep(plan_of(request, FORMS), out, workers=workers)
    assert outcome.theory is not None
    assert all(result.is_over for result in outcome.results)
    good = np.array([result.is_good for result in outcome.results]).reshape(shape)
    return good, np.array([is_stable(radius) for radius in outcome.theory]).reshape(shape)


def wrong(good: NDArray[np.bool_], stable: NDArray[np.bool_]) -> list[tuple[int, ...]]:
    """Cells in which the two differ, and which do not lie at the theory's boundary."""
    near = np.ones((3, 3), dtype=bool)
    crossed = binary_dilation(stable, near) & binary_dilation(~stable, near)
    return [tuple(map(int, cell)) for cell in np.argwhere((good != stable) & ~crossed)]


@pytest.mark.parametrize("architecture", MAPS)
def test_a_coarse_map_agrees(architecture: str, tmp_path: Path) -> None:
    good, stable = maps(architecture, (8, 6), 3, tmp_path / "map", 0)
    assert wrong(good, stable) == []
    assert 0 < stable.sum() < stable.size
    # Against the theory of other delays it does not.
    assert wrong(good, stable[::-1]) != []


@pytest.mark.slow
@pytest.mark.parametrize("architecture", MAPS)
def test_the_map_agrees_in_every_cell(architecture: str, tmp_path: Path) -> None:
    began, before = time.monotonic(), os.times()
    good, stable = maps(architecture, (40, 40), 6, tmp_path / "map", 2)
    after = os.times()
    used = sum(after[:4]) - sum(before[:4])
    assert wrong(good, stable) == []
    # Under a minute on two processors, as far as they were ours.
    assert min(time.monotonic() - began, used / 2) < 60
