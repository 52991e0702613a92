"""Measures of a whole scenario: was the box held, how steadily, and do the copies agree?

Each can be the target of an expectation, and each stands in the summary where it applies. To have
a new one, write a function of the run and a range of ticks and add it to ``SCENARIO_MEASURES`` with
the signals that it reads; of these it may take for granted that every row holds a finite number.

The *hold phase*, over which holding is judged unless a window is given, begins ``SETTLING`` after
the first tick at which every finger that ever touches the box does, and lasts to the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from cosim.record.reader import Run
from cosim.report.platform import Contact, RecordedPlatform, platform_of
from cosim.report.target import Target, aligned
from cosim.report.verdict.lack import lack_of
from cosim.report.window import MEASURES, Window, measure

TickRange = tuple[int, int]
"""Base ticks, the second one not included."""
Extremes = tuple[float, float]
"""The least and the greatest value; NaN where there is none, or a row has no number."""

_UNKNOWN: Extremes = (math.nan, math.nan)

SETTLING = 0.5
"""From the first common contact to the hold phase (s)."""


class Inspection:
    """A run under measurement: what several measures need of it is found once."""

    def __init__(self, run: Run, extremes: Mapping[str, Extremes] | None = None) -> None:
        """``extremes`` are those of whole signals, where somebody has found them already."""
        self.run = run
        self._extremes = extremes or {}
        self.platform = platform_of(run)
        self._windows: dict[tuple[Target, TickRange], Window] = {}
        self._values: dict[tuple[str, TickRange | None], float | None] = {}

    def value(self, name: str, window: TickRange | None = None) -> float | None:
        """A scenario measure over a window, or over the range that it chooses itself.

        ``None`` where it does not apply, NaN where :meth:`lack` says what is missing.
        """
        key = (name, window)
        if key not in self._values:
            value = SCENARIO_MEASURES[name].function(self, window)
            lacking = value is not None and self.lack(name, window)
            self._values[key] = math.nan if lacking else value
        return self._values[key]

    def lack(self, name: str, window: TickRange | None) -> str:
        """What keeps a scenario measure from being told: a sentence without its end, or nothing."""
        measure = SCENARIO_MEASURES[name]
        first, last = window or (0, self.run.ticks)
        held = self.held(window) if measure.of_hold_phase else None
        begin, end = held[0] if held is not None else (first, last)
        for signal in sorted(measure.reads(self.platform)):
            # What holding is found by is looked at from the beginning on.
            said = self._lack_of(signal, begin, end, measure.samples)
            said = said or self._lack_of(signal, first, last, 1)
            if said:
                return said
        return ""

    def _lack_of(self, signal: str, first: int, last: int, samples: int) -> str:
        """The same of one signal; of one that is known to be finite the rows are counted alone."""
        if all(map(math.isfinite, self._extremes.get(signal, _UNKNOWN))):
            group = self.run[signal].group
            covered = min(last, group.rows * group.period)
            if group.first_row_at(covered) - group.first_row_at(first) >= samples:
                return ""
        return lack_of(self.run, _one(signal), first, last, samples)

    def window(self, target: Target, first: int, last: int) -> Window:
        """A target's statistics over ``first`` <= tick < ``last``."""
        key = (target, (first, last))
        if key not in self._windows:
            self._windows[key] = measure(self.run, target, first, last)
        return self._windows[key]

    def extremes(self, signal: str, first: int, last: int) -> Extremes:
        """The least and the greatest value of a signal over ``first`` <= tick < ``last``."""
        if signal in self._extremes and self.run[signal].group.covers(first, last):
            return self._extremes[signal]
        window = self.window(_one(signal), first, last)
        return (window.minimum, window.maximum) if window.is_finite else (math.nan, math.nan)

    def ever(self, signal: str) -> bool:
        """Whether a signal is anything but 0 at any tick."""
        if signal in self._extremes:
            return self.run[signal].group.rows > 0 and self._extremes[signal] != (0, 0)
        return any(bool(block.any()) for block in self.run[signal].blocks())

    @cached_property
    def hold_phase(self) -> tuple[TickRange, tuple[Contact, ...]] | None:
        """The hold phase and the contacts that count; ``None`` if the box is never held by all."""
        run = self.run
        touching = tuple(each for each in self.platform.contacts if self.ever(each.state))
        if not touching:
            return None
        for ticks, states in aligned(run, [contact.state for contact in touching], 0, run.ticks):
            together = np.logical_and.reduce([state != 0 for state in states])
            if together.any():
                first = int(ticks[np.argmax(together)]) + math.ceil(SETTLING * run.base_rate)
                return (min(first, run.ticks), run.ticks), touching
        return None

    def held(self, window: TickRange | None) -> tuple[TickRange, tuple[Contact, ...]] | None:
        """The hold phase, or a window in its place, and the contacts that count."""
        phase = self.hold_phase
        return phase if phase is None or window is None else (window, phase[1])


@dataclass(frozen=True, slots=True)
class ScenarioMeasure:
    """A number about a run, in an SI ``unit``; ``None`` where it does not apply."""

    unit: str
    description: str
    function: Callable[[Inspection, TickRange | None], float | None]
    reads: Callable[[RecordedPlatform], Collection[str]]
    """The signals it takes; none where it does not apply to what is recorded."""
    of_hold_phase: bool = False
    samples: int = 1
    """How many rows of each signal it takes."""
    most: float = math.inf
    """The most that it can be; the least is 0 of each."""


def _contact_losses(measured: Inspection, window: TickRange | None) -> float | None:
    held = measured.held(window)
    if held is None:
        return None
    (first, last), contacts = held
    windows = [measured.window(_one(contact.state), first, last) for contact in contacts]
    # Where there is nothing to look at, nothing was held all along.
    return sum(each.losses for each in windows) if all(each.rows for each in windows) else None


def _held_fraction(measured: Inspection, window: TickRange | None) -> float | None:
    held = measured.held(window)
    if held is None:
        return 0.0 if measured.platform.contacts else None
    (first, last), contacts = held
    rows = held_rows = 0
    for ticks, states in aligned(
        measured.run, [contact.state for contact in contacts], first, last
    ):
        rows += ticks.size
        held_rows += int(np.count_nonzero(np.logical_and.reduce([s != 0 for s in states])))
    return held_rows / rows if rows else None


def _force_ripple(measured: Inspection, window: TickRange | None) -> float | None:
    return _over_forces(measured, window, "std", max)


def _grip_force(measured: Inspection, window: TickRange | None) -> float | None:
    return _over_forces(measured, window, "mean", min)


def _over_forces(
    measured: Inspection,
    window: TickRange | None,
    name: str,
    choose: Callable[[list[float]], float],
) -> float | None:
    held = measured.held(window)
    if held is None:
        return None
    (first, last), contacts = held
    forces = [contact.normal_force for contact in contacts if contact.normal_force is not None]
    if len(forces) < len(contacts):
        return None  # the one that is not recorded may be the one to choose
    return _chosen(
        choose, [MEASURES[name](measured.window(_one(force), first, last)) for force in forces]
    )


def _drift(measured: Inspection, window: TickRange | None) -> float | None:
    return _over_copies(measured, window, slice(0, 2), "max")


def _drift_rms(measured: Inspection, window: TickRange | None) -> float | None:
    return _over_copies(measured, window, slice(0, 2), "rms")


def _drift_angle(measured: Inspection, window: TickRange | None) -> float | None:
    return _over_copies(measured, window, slice(2, 3), "max")


def _over_copies(
    measured: Inspection, window: TickRange | None, parts: slice, name: str
) -> float | None:
    first, last = window or (0, measured.run.ticks)
    found: list[float] = []
    for one, other in combinations(measured.platform.copies, 2):
        target = Target(
            "",
            measured.platform.poses[one][parts],
            measured.platform.poses[other][parts],
            is_norm=True,
        )
        found.append(MEASURES[name](measured.window(target, first, last)))
    return _chosen(max, found)


def _box_displacement(measured: Inspection, window: TickRange | None) -> float | None:
    first, last = window or (0, measured.run.ticks)
    found: list[float] = []
    for pose in measured.platform.poses.values():
        start: list[float] | None = None
        for _, values in aligned(measured.run, pose[:2], first, last):
            start = start or [float(value[0]) for value in values]
            found.append(
                float(np.hypot(values[0] - start[0], values[1] - start[1]).max(initial=0.0))
            )
    return _chosen(max, found)


def _wall_penetration(measured: Inspection, window: TickRange | None) -> float | None:
    first, last = window or (0, measured.run.ticks)
    found = [measured.extremes(name, first, last)[1] for name in measured.platform.depths.values()]
    return _chosen(max, found)


def _saturated_ticks(measured: Inspection, window: TickRange | None) -> float | None:
    first, last = window or (0, measured.run.ticks)
    counters = [measured.extremes(name, first, last) for name in measured.platform.saturations]
    return sum(most - least for least, most in counters) if counters else None


def _chosen(choose: Callable[[list[float]], float], found: list[float]) -> float | None:
    """One of them; NaN where one is, which would hide behind the others otherwise."""
    if not found:
        return None
    return math.nan if any(map(math.isnan, found)) else choose(found)


def _states(platform: RecordedPlatform) -> Collection[str]:
    return [contact.state for contact in platform.contacts]


def _forces(platform: RecordedPlatform) -> Collection[str]:
    forces = [each.normal_force for each in platform.contacts if each.normal_force is not None]
    return [*_states(platform), *forces] if forces else []


def _copies(platform: RecordedPlatform) -> Collection[str]:
    return _boxes(platform) if len(platform.copies) > 1 else []


def _boxes(platform: RecordedPlatform) -> Collection[str]:
    return [name for pose in platform.poses.values() for name in pose]


def signals_of(platform: RecordedPlatform) -> set[str]:
    """The signals that the measures read."""
    return {name for each in SCENARIO_MEASURES.values() for name in each.reads(platform)}


def _one(name: str) -> Target:
    return Target(name, (name,))


SCENARIO_MEASURES: dict[str, ScenarioMeasure] = {
    "contact_losses": ScenarioMeasure(
        "",
        "contacts that ended in the hold phase, over all fingers and copies",
        _contact_losses,
        _states,
        of_hold_phase=True,
        samples=2,
    ),
    "held_fraction": ScenarioMeasure(
        "1",
        "share of the hold phase in which every finger is in contact",
        _held_fraction,
        _states,
        of_hold_phase=True,
        most=1.0,
    ),
    "grip_force": ScenarioMeasure(
        "N",
        "mean normal force in the hold phase, of the weakest contact",
        _grip_force,
        _forces,
        of_hold_phase=True,
    ),
    "force_ripple": ScenarioMeasure(
        "N",
        "rms deviation of the normal force from its mean in the hold phase, of the worst contact "
        "(of two worlds, in either of them)",
        _force_ripple,
        _forces,
        of_hold_phase=True,
        samples=2,
    ),
    "drift": ScenarioMeasure(
        "m", "largest distance between two copies of the box", _drift, _copies
    ),
    "drift_rms": ScenarioMeasure(
        "m", "rms distance between two copies of the box", _drift_rms, _copies
    ),
    "drift_angle": ScenarioMeasure(
        "rad", "largest angle between two copies", _drift_angle, _copies
    ),
    "box_displacement": ScenarioMeasure(
        "m", "largest distance of the box from where it began", _box_displacement, _boxes, samples=2
    ),
    "wall_penetration": ScenarioMeasure(
        "m",
        "depth of the deepest corner in a wall",
        _wall_penetration,
        lambda platform: platform.depths.values(),
    ),
    "saturated_ticks": ScenarioMeasure(
        "",
        "ticks in which a finger was to be given more force than its device can, over all fingers; "
        "of two worlds, each counts what it asks for, felt or not",
        _saturated_ticks,
        lambda platform: platform.saturations,
        samples=2,
    ),
}
