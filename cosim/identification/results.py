"""What is told of a device: each value with its interval, or that these runs do not tell it.

Chance is not all that a value is off by: joints stick where they turn, smoothing bends what it
smooths, counts bias what they are squared in. What remains of that was seen on emulated devices
whose every number is known, and is added to each interval as ``OWN_ERROR``.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from cosim.base.errors import InputError
from cosim.identification.equations import Stretch, stretches
from cosim.identification.fit import NO_FIVE_BAR, SHAPES, Choice, Fit, Length, fit
from cosim.identification.five_bar import Array
from cosim.identification.regressor import INERTIAS, PARAMETERS, Coefficient, inertia_matrix
from cosim.identification.samples import Counts, Described, Recording
from cosim.identification.whiteness import Whiteness, whiteness

CONFIDENCE = 0.95
WIDEST = 0.5
"""Half an interval as a share of the value: beyond it the runs do not tell the value."""
WIDEST_ABSOLUTE = {"latency": 5e-4, "offset": 10e-3, "bias": 1e-3}
"""The same for what may be zero, in its unit."""
OWN_ERROR = {"J": 0.01, "M": 0.01, "phi": 0.05, "home": 0.007, "coulomb": 0.006, "gain": 0.004}
"""Standard deviation as a share of the value."""
OWN_ERROR_ABSOLUTE = {"latency": 2e-5, "offset": 1e-3, "bias": 2e-5}
VISCOUS_SHARE = 0.01
"""Of Coulomb friction at the rate's rms: the two look alike where rates are alike."""
LENGTH_OFF, LENGTH_CERTAIN = 0.01, 4.0
"""A length that is off by more than this share, and by so many standard deviations, is told of."""
LEAST_EXPLAINED = 0.5
"""Share of the torque below which the model is not that of the device."""
SEEN = 0.05
"""Share of a hidden direction in a parameter from which on it is not told."""
HOME = (
    Coefficient("home_11", "kg.m2", "inertia that motor 1 feels at the home pose"),
    Coefficient("home_12", "kg.m2", "inertia between the motors at the home pose"),
    Coefficient("home_22", "kg.m2", "inertia that motor 2 feels at the home pose"),
)
WAY_TO_GAIN = "needs a run without and one with a known mass on the tip, or a force sensor"


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """One quantity: ``value`` is ``None`` where ``reason`` says why the runs do not tell it."""

    name: str
    unit: str
    description: str
    value: float | None
    low: float | None
    high: float | None
    reason: str = ""

    def __str__(self) -> str:
        """``latency = 0.000977 s (0.000937 to 0.001016)``, or why it is not told."""
        if self.value is None:
            return f"{self.name} is not told: {self.reason}"
        return f"{self.name} = {self.value:.4g} {self.unit} ({self.low:.4g} to {self.high:.4g})"


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Identified:
    """All of it. ``pose`` (rad) is the home pose, or the mean one where there is none."""

    described: Described
    estimates: tuple[Estimate, ...]
    runs: tuple[Recording, ...]
    counts: Counts
    white: Whiteness
    fit: Fit
    rows: tuple[Stretch, ...]
    pose: tuple[float, float]
    alike: bool
    explained: float

    def __getitem__(self, name: str) -> Estimate:
        return next(each for each in self.estimates if each.name == name)

    @property
    def wrong_lengths(self) -> tuple[Length, ...]:
        """Lengths of the five-bar that the residual hangs together with: one of them is wrong."""
        return tuple(
            each
            for each in self.fit.lengths
            if abs(each.share) > max(LENGTH_OFF, LENGTH_CERTAIN * each.deviation)
        )

    @property
    def is_whole(self) -> bool:
        """Whether nothing that the model lacks was seen: a white residual, and right lengths."""
        return self.white.is_white and not self.wrong_lengths

    def __repr__(self) -> str:
        return "\n".join(str(each) for each in self.estimates)


def identify(
    described: Described,
    recordings: list[Recording],
    steps: list[int],
    *,
    alike: bool = True,
    friction: bool = True,
    offsets: bool = True,
) -> Identified:
    """What the recordings of one device tell.

    Args:
        described: geometry, torque limit and declared latency of the device.
        recordings: its runs.
        steps: base ticks from row to row of each.
        alike: whether both sides have the same inertia, as a device is made.
        friction: whether there is any; without, it is not told.
        offsets: whether encoders may show too much; without, they are taken at their word.

    Raises:
        InputError: they are too short, hardly move, or do not tell the inertia, or their ticks
            differ.
    """
    if len({each.tick for each in recordings}) > 1:
        raise InputError("the runs have device rates that differ: identify those of one rate.")
    rows = stretches(described.bar, recordings, steps)
    gains = len({each.payload or 0.0 for each in recordings}) > 1 or any(
        each.force is not None for each in recordings
    )
    choice = Choice(alike=alike, free=(True, offsets, offsets, gains, gains), friction=friction)
    tick = recordings[0].tick
    found = fit(described.bar, rows, described.latency_ticks * tick, choice)
    mean = np.mean(np.concatenate([each.angle for each in rows]), axis=0)
    pose = described.home or (float(mean[0]), float(mean[1]))
    without: set[str] = set()
    if not friction:
        without |= {"coulomb", "viscous", "bias"}
    if not offsets:
        without.add("offset")
    estimates = _estimates(described, rows, found, pose, gains=gains, without=without)
    used = sum(len(each.held) for each in rows)
    power = float(np.mean(found.torque**2))
    explained = 1.0 - float(np.mean(found.residual**2)) / power
    _refuse_what_is_none(described, pose, found, explained)
    return Identified(
        described=described,
        estimates=tuple(estimates),
        runs=tuple(recordings),
        counts=Counts.of(recordings, used, steps),
        white=whiteness(rows, found.residual),
        fit=found,
        rows=tuple(rows),
        pose=pose,
        alike=alike,
        explained=explained,
    )


def _refuse_what_is_none(
    described: Described, pose: tuple[float, float], found: Fit, explained: float
) -> None:
    """Raise where the result is no mechanism, or the runs do not show its inertia."""
    inertia = inertia_matrix(described.bar, pose)
    weight = np.zeros(len(found.values))
    for row, column in ((0, 0), (0, 1), (1, 1)):
        weight[: len(INERTIAS)] = inertia[row, column]
        if _is_hidden(weight, found):
            raise InputError(
                "these runs do not show the inertia at the home pose: other parameters explain "
                f"them as well (condition {found.condition:.3g}). Both joints have to be moved, "
                "slowly and quickly: run the excitation of 'cohaptic identify --plan'."
            )
    moments = np.linalg.eigvalsh(inertia @ found.values[: len(INERTIAS)])
    if explained < LEAST_EXPLAINED or moments[0] <= 0.0:
        raise InputError(NO_FIVE_BAR)


def _estimates(
    described: Described,
    rows: list[Stretch],
    found: Fit,
    pose: tuple[float, float],
    *,
    gains: bool,
    without: set[str],
) -> list[Estimate]:
    stats: Any = import_module("scipy.stats")
    factor = float(stats.t.ppf(0.5 + CONFIDENCE / 2, found.freedom))
    rate = float(np.sqrt(np.mean(np.concatenate([each.rate for each in rows]) ** 2)))
    weights = np.eye(len(found.values))
    at_home = inertia_matrix(described.bar, pose)
    made: list[Estimate] = []
    table: list[tuple[Coefficient, Array]] = []
    for parameter, (row, column) in zip(HOME, ((0, 0), (0, 1), (1, 1)), strict=True):
        weight = np.zeros(len(found.values))
        weight[: len(INERTIAS)] = at_home[row, column]
        table.append((parameter, weight))
    everything = zip((*PARAMETERS, *SHAPES), weights, strict=True)
    table += [(each, weight) for each, weight in everything if _kind(each.name) not in without]
    for parameter, weight in table:
        value = float(weight @ found.values)
        chance = float(np.sqrt(max(0.0, weight @ found.covariance @ weight)))
        own = _own_error(parameter.name, value, found, rate)
        half = factor * float(np.hypot(chance, own))
        reason = _reason(parameter.name, weight, value, half, found, gains=gains)
        known = not (parameter.name.startswith("gain") and not gains) and not _is_hidden(
            weight, found
        )
        made.append(
            Estimate(
                name=parameter.name,
                unit=parameter.unit,
                description=parameter.description,
                value=None if reason else value,
                low=value - half if known else None,
                high=value + half if known else None,
                reason=reason,
            )
        )
    return made


def _kind(name: str) -> str:
    return name.partition("_")[0]


def _own_error(name: str, value: float, found: Fit, rate: float) -> float:
    kind = _kind(name)
    if kind == "viscous":
        side = int(name[-1]) - 1
        return VISCOUS_SHARE * abs(float(found.values[len(INERTIAS) + side])) / rate
    return OWN_ERROR_ABSOLUTE.get(kind, 0.0) + OWN_ERROR.get(kind, 0.0) * abs(value)


def _is_hidden(weight: Array, found: Fit) -> bool:
    """Whether a direction that the runs do not show has a part in a quantity."""
    if not found.hidden.shape[1]:
        return False
    reach = np.linalg.norm(found.hidden, axis=1)
    return bool(np.max(np.abs(weight @ found.hidden)) > SEEN * np.linalg.norm(weight * reach)) and (
        bool(np.max(np.abs(weight @ found.hidden)) > SEEN * np.max(np.abs(weight)))
    )


def _reason(name: str, weight: Array, value: float, half: float, found: Fit, *, gains: bool) -> str:
    kind = _kind(name)
    if kind == "gain" and not gains:
        return WAY_TO_GAIN
    if _is_hidden(weight, found):
        return "other parameters explain these runs as well"
    widest = WIDEST_ABSOLUTE.get(kind, WIDEST * abs(value))
    return "" if half <= widest else "its interval is too wide"
