"""The derivative of Φ by central differences, and whether it has one."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.chance.fate import PeriodFate
from cosim.analysis.monodromy.run_map import DiscreteChangeError, RunMap
from cosim.analysis.monodromy.structure import NOBODY, MapStructure
from cosim.base.errors import InputError

Real = NDArray[np.float64]
Fates = Mapping[int, PeriodFate] | None

TOLERANCE = 1e-5
"""How far the differences of two steps may lie apart, of the largest entry of their row and one."""
CHECKED = 0.125
"""The share of their steps by which all numbers are moved at once to check a grouped derivative."""
AGREES = 1e-6
"""How far that may lie apart, of the sum of what it should be made of."""


class _StructureError(Exception):
    """The run does not have the structure that its derivative nearby has."""


def jacobian(run: RunMap, state: Real | None = None, fates: Fates = None) -> Real:
    """dΦ/dx at a state, shape (n, n): central differences of two steps, extrapolated (Richardson).

    The first derivative of a run is made one number at a time. Where the structure of one nearby is
    known, numbers that move nothing in common are moved together, and a run in which all are moved
    says whether the structure still holds; if not, it is made one number at a time again.

    Raises:
        InputError: a mode changes within the steps, or the two differences disagree: there is no
            derivative there.
    """
    at = run.start if state is None else state
    run.undisturbed(at, fates)
    structure = _known_structure(run, fates)
    if structure is not None:
        try:
            return _grouped(run, at, fates, structure)
        except (_StructureError, DiscreteChangeError, InputError):
            run.undisturbed(at, fates)  # what is wrong is said of one number
    matrix = _column_by_column(run, at, fates)
    run.structures[_key(fates)] = MapStructure.of(matrix)
    return matrix


def _known_structure(run: RunMap, fates: Fates) -> MapStructure | None:
    """That of a derivative before; with other fates only what packets move is another."""
    known, usual = run.structures.get(_key(fates)), run.structures.get(())
    if known is None and usual is not None:
        known = run.structures[_key(fates)] = usual.widened(run.carried)
    return known


def _key(fates: Fates) -> tuple[tuple[int, PeriodFate], ...]:
    return tuple(sorted((fates or {}).items()))


def _column_by_column(run: RunMap, at: Real, fates: Fates) -> Real:
    found: dict[float, Real] = {}
    for share in (1.0,) if run.is_linear else (1.0, 0.5):
        found[share] = np.zeros((at.size, at.size))
        for number in range(at.size):
            try:
                ends, width = _difference(run, at, np.array([number]), share, fates)
            except DiscreteChangeError as changed:
                raise InputError(
                    f"At tick {run.tick} the run is at an edge: moving {run.coordinates[number]} "
                    f"by {share * run.steps[number]:g} {run.coordinates[number].unit} changes "
                    f"{changed}. Choose another moment with --at, or what is held there more "
                    "firmly."
                ) from None
            found[share][:, number] = ends / width
    return _extrapolated(run, found)


def _grouped(run: RunMap, at: Real, fates: Fates, structure: MapStructure) -> Real:
    found: dict[float, Real] = {}
    for share in (1.0,) if run.is_linear else (1.0, 0.5):
        found[share] = np.zeros((at.size, at.size))
        for columns, owners in structure.groups:
            ends, width = _difference(run, at, columns, share, fates)
            moved = np.flatnonzero(ends)
            if (owners[moved] == NOBODY).any():
                raise _StructureError
            widths = np.zeros(at.size)
            widths[columns] = width
            found[share][moved, owners[moved]] = ends[moved] / widths[owners[moved]]
    matrix = _extrapolated(run, found)
    _check(run, at, fates, matrix)
    return matrix


def _check(run: RunMap, at: Real, fates: Fates, matrix: Real) -> None:
    """Whether everything moved at once moves what the columns say together."""
    weights = np.random.default_rng(at.size).uniform(0.3, 1.0, at.size)
    weights[::2] *= -1.0
    moved = CHECKED * weights * run.steps
    seen = 0.5 * (run(at + moved, fates) - run(at - moved, fates))
    # What moving a number of its size leaves of rounding in the row is allowed too.
    allowed = AGREES * (np.abs(matrix) @ np.abs(moved) + CHECKED * run.steps)
    if (np.abs(seen - matrix @ moved) > allowed).any():
        raise _StructureError


def _extrapolated(run: RunMap, found: Mapping[float, Real]) -> Real:
    """The limit of two differences.

    Raises:
        InputError: they disagree.
    """
    whole = found[1.0]
    if run.is_linear:  # exact at any step
        return whole
    half = found[0.5]
    # What is linear is exact already, and structural zeros and ones stay what they are.
    matrix = np.where(whole == half, half, (4.0 * half - whole) / 3.0)
    size = run.steps
    apart = np.abs(half - whole) * size[None, :] / size[:, None]
    scale = np.maximum(np.abs(matrix * size[None, :] / size[:, None]).max(axis=1, initial=1.0), 1.0)
    row, column = np.unravel_index(int(np.argmax(apart / scale[:, None])), apart.shape)
    if size.size and apart[row, column] > TOLERANCE * scale[row]:
        raise InputError(
            f"The run has no derivative at tick {run.tick}: how {run.coordinates[row]} follows "
            f"{run.coordinates[column]} depends on how far that is moved. Something switches there "
            "(friction, a saturation, a quantised value): choose another moment with --at."
        )
    return matrix


def _difference(
    run: RunMap, at: Real, columns: NDArray[np.int64], share: float, fates: Fates
) -> tuple[Real, Real]:
    """What moving numbers both ways moves, shape (n,), and how far apart they were, (columns,).

    Raises:
        DiscreteChangeError: something else than numbers came out differently.
    """
    ends: list[Real] = []
    places: list[Real] = []
    for sign in (1.0, -1.0):
        moved = at.copy()
        moved[columns] += sign * share * run.steps[columns]
        places.append(moved[columns])
        ends.append(run(moved, fates))
    return ends[0] - ends[1], places[0] - places[1]
