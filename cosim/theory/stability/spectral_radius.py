"""Spectral radius of a loop, and all stable intervals along a parameter."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.assembly import assemble
from cosim.theory.models.direct import direct_model
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Real, find_root, minimise_bounded
from cosim.theory.stability.quotient import Spectrum, decisive_spectrum

_FINEST = 1e-13


@dataclass(frozen=True, slots=True)
class Stability:
    """Whether a loop is stable.

    Attributes:
        spectral_radius: ρ over one network period, neutral motions apart.
        marginal: whether momentum is conserved, so that the common velocity was taken out as well.
        spectrum: the eigenvalues over one hyperperiod, largest first.
    """

    spectral_radius: float
    marginal: bool
    spectrum: Spectrum

    @property
    def stable(self) -> bool:
        """ρ < 1, by more than rounding makes of a neutral motion."""
        return self.spectral_radius < 1.0 - 1e-12


def stability(model: Model, timing: Timing) -> Stability:
    """The spectral radius that decides the stability of a loop, at any ratio of the rates.

    A ratio p/q that is not whole is lifted over its hyperperiod, and ρ is brought back to one
    network period by the q-th root. A delay between two samples is lifted as well.
    """
    if timing.has_frame:
        frame = assemble(model, timing).frame()
        spectrum = decisive_spectrum(frame.map, None if model.grounded else frame.translation)
        return Stability(spectrum.radius, spectrum.marginal, spectrum)
    direct = direct_model(model, timing)
    spectrum = decisive_spectrum(direct.lifted.map, None if model.grounded else direct.translation)
    radius = spectrum.radius ** (1.0 / direct.network_samples)
    return Stability(radius, spectrum.marginal, spectrum)


def stable_intervals(
    radius: Callable[[float], float], low: float, high: float, points: int = 600
) -> list[tuple[float, float]]:
    """All intervals of [low, high] where ``radius`` is below 1.

    Regions are re-entrant, so the whole range is sampled (half of the points evenly, half
    geometrically), every crossing is refined by root finding, and every local extremum of the
    samples on the wrong side of 1 is searched for a pair of crossings between two samples.

    Args:
        radius: the spectral radius as a function of the parameter.
        low: start of the range.
        high: end of the range, above ``low``.
        points: number of samples.

    Raises:
        InputError: where the range is empty.
    """
    if not low < high:
        raise InputError(f"The range {low:g}:{high:g} is empty: give LOW:HIGH with LOW below HIGH.")
    grid = _grid(low, high, points)
    values = np.array([radius(float(value)) - 1.0 for value in grid])
    return _intervals(radius, grid, values, _FINEST)


def stable_interval_around(
    radius: Callable[[float], float],
    inside: float,
    low: float,
    high: float,
    points: int,
    *,
    accuracy: float = _FINEST,
) -> tuple[float, float] | None:
    """The interval of [low, high] around a value where ``radius`` is below 1; None if it is not.

    The samples are those of ``stable_intervals``, taken outwards from the value for as long as they
    are stable, so that what lies beyond is not asked.

    Args:
        radius: as there.
        inside: the value.
        low: start of the range.
        high: end of the range.
        points: number of samples of the whole range.
        accuracy: of the ends.
    """
    if radius(inside) >= 1.0:
        return None
    grid = _grid(low, high, points)
    known = {inside: radius(inside) - 1.0}
    for values in (grid[grid > inside], grid[grid < inside][::-1]):
        for value in map(float, values):
            known[value] = radius(value) - 1.0
            if known[value] >= 0.0:
                break
    taken = np.array(sorted(known))
    found = _intervals(radius, taken, np.array([known[v] for v in taken.tolist()]), accuracy)
    return next((each for each in found if each[0] <= inside <= each[1]), None)


def _intervals(
    radius: Callable[[float], float], grid: Real, values: Real, accuracy: float
) -> list[tuple[float, float]]:
    """Those between the samples' ends."""
    low, high = float(grid[0]), float(grid[-1])
    grid, values = _with_hidden_extrema(radius, grid, values)
    edges = [
        _crossing(radius, float(grid[left]), float(grid[left + 1]), accuracy)
        for left in range(grid.size - 1)
        if (values[left] < 0) != (values[left + 1] < 0)
    ]
    stable_now = bool(values[0] < 0)
    marks = [low, *edges, high]
    intervals: list[tuple[float, float]] = []
    for start, stop in itertools.pairwise(marks):
        if stable_now:
            intervals.append((start, stop))
        stable_now = not stable_now
    return intervals


def _grid(low: float, high: float, points: int) -> Real:
    even = np.linspace(low, high, points // 2)
    if low >= 0.0:
        start = low if low > 0.0 else high * 1e-6
        return np.union1d(even, np.clip(np.geomspace(start, high, points // 2), low, high))
    return even


def _crossing(
    radius: Callable[[float], float], left: float, right: float, accuracy: float
) -> float:
    at_left, at_right = radius(left) - 1.0, radius(right) - 1.0
    if at_left == 0.0:
        return left
    if at_right == 0.0:
        return right
    return find_root(lambda value: radius(value) - 1.0, left, right, accuracy)


def _with_hidden_extrema(
    radius: Callable[[float], float], grid: Real, values: Real
) -> tuple[Real, Real]:
    """The samples, with extrema between them that lie on the other side of 1 added."""
    extra: list[tuple[float, float]] = []
    for middle in range(1, grid.size - 1):
        before, here, after = values[middle - 1 : middle + 2]
        if (before < 0) != (here < 0) or (here < 0) != (after < 0):
            continue
        sign = 1.0 if here >= 0 else -1.0
        if sign * here > sign * before or sign * here > sign * after:
            continue
        # Worth a search only where the neighbours' slopes could carry it across 1.
        reach = max(abs(before - here), abs(after - here))
        if abs(here) > 2.0 * reach:
            continue
        place, value = minimise_bounded(
            lambda v, s=sign: s * (radius(v) - 1.0),
            float(grid[middle - 1]),
            float(grid[middle + 1]),
        )
        if value < 0:
            extra.append((place, sign * value))
    if not extra:
        return grid, values
    all_points = np.concatenate([grid, [place for place, _ in extra]])
    all_values = np.concatenate([values, [value for _, value in extra]])
    order = np.argsort(all_points, kind="stable")
    return all_points[order], all_values[order]
