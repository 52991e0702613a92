"""The derivative of Φ by central differences, and whether it has one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.chance.fate import PeriodFate
from cosim.analysis.monodromy.run_map import DiscreteChangeError, RunMap
from cosim.base.errors import InputError

Real = NDArray[np.float64]

TOLERANCE = 1e-5
"""How far the differences of two steps may lie apart, of the largest entry of their row and one."""


def jacobian(
    run: RunMap, state: Real | None = None, fates: Mapping[int, PeriodFate] | None = None
) -> Real:
    """dΦ/dx at a state, shape (n, n): central differences of two steps, extrapolated (Richardson).

    Raises:
        InputError: a mode changes within the steps, or the two differences disagree: there is no
            derivative there.
    """
    at = run.start if state is None else state
    run.undisturbed(at, fates)
    matrix = np.zeros((at.size, at.size))
    rough = np.zeros((at.size, at.size))
    for number in range(at.size):
        whole = _difference(run, at, number, 1.0, fates)
        if run.is_linear:  # exact at any step
            matrix[:, number] = whole
            continue
        half = _difference(run, at, number, 0.5, fates)
        # What is linear is exact already, and structural zeros and ones stay what they are.
        same = whole == half
        matrix[:, number] = np.where(same, half, (4.0 * half - whole) / 3.0)
        rough[:, number] = np.abs(half - whole)
    size = _sizes(run)
    apart = rough * size[None, :] / size[:, None]
    scale = np.maximum(np.abs(matrix * size[None, :] / size[:, None]).max(axis=1, initial=1.0), 1.0)
    row, column = np.unravel_index(int(np.argmax(apart / scale[:, None])), apart.shape)
    if at.size and apart[row, column] > TOLERANCE * scale[row]:
        raise InputError(
            f"The run has no derivative at tick {run.tick}: how {run.coordinates[row]} follows "
            f"{run.coordinates[column]} depends on how far that is moved. Something switches there "
            "(friction, a saturation, a quantised value): choose another moment with --at."
        )
    return matrix


def _sizes(run: RunMap) -> Real:
    """A natural size of each coordinate: its step."""
    return run.steps


def _difference(
    run: RunMap, at: Real, number: int, share: float, fates: Mapping[int, PeriodFate] | None
) -> Real:
    ends: list[Real] = []
    places: list[float] = []
    for sign in (1.0, -1.0):
        moved = at.copy()
        moved[number] += sign * share * run.steps[number]
        places.append(float(moved[number]))
        try:
            ends.append(run(moved, fates))
        except DiscreteChangeError as changed:
            raise InputError(
                f"At tick {run.tick} the run is at an edge: moving {run.coordinates[number]} by "
                f"{share * run.steps[number]:g} {run.coordinates[number].unit} changes {changed}. "
                "Choose another moment with --at, or what is held there more firmly."
            ) from None
    return (ends[0] - ends[1]) / (places[0] - places[1])
