"""Measures of a whole scenario: was the box held, how steadily, and do the copies agree?

Each can be the target of an expectation, and each stands in the summary where it applies. To have
a new one, write a function of the run and a range of ticks and add it to ``SCENARIO_MEASURES``.

The *hold phase*, over which holding is judged unless a window is given, begins ``SETTLING`` after
the first tick at which every finger that ever touches the box does, and lasts to the end.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from cosim.record.reader import Run
from cosim.report.platform import Contact, RecordedPlatform, find_platform
from cosim.report.target import Target, aligned
from cosim.report.window import measure

TickRange = tuple[int, int]
"""Base ticks, the second one not included."""

SETTLING = 0.5
"""From the first common contact to the hold phase (s)."""


@dataclass(frozen=True, slots=True)
class ScenarioMeasure:
    """A number about a run, in an SI ``unit``; ``None`` where it does not apply."""

    unit: str
    description: str
    function: Callable[[Run, RecordedPlatform, TickRange | None], float | None]
    of_hold_phase: bool = False

    def take(self, run: Run, window: TickRange | None = None) -> float | None:
        """Measure over a window, or over the range that the measure itself chooses."""
        return self.function(run, find_platform(run.signals), window)


def hold_phase(
    run: Run, platform: RecordedPlatform
) -> tuple[TickRange, tuple[Contact, ...]] | None:
    """The hold phase and the contacts that count; ``None`` if the box is never held by all."""
    touching = tuple(contact for contact in platform.contacts if _ever(run, contact))
    if not touching:
        return None
    for ticks, states in aligned(run, [contact.state for contact in touching], 0, run.ticks):
        together = np.logical_and.reduce([state != 0 for state in states])
        if together.any():
            first = int(ticks[np.argmax(together)]) + math.ceil(SETTLING * run.base_rate)
            return (min(first, run.ticks), run.ticks), touching
    return None


def _held(
    run: Run, platform: RecordedPlatform, window: TickRange | None
) -> tuple[TickRange, tuple[Contact, ...]] | None:
    phase = hold_phase(run, platform)
    return phase if phase is None or window is None else (window, phase[1])


def _contact_losses(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    held = _held(run, platform, window)
    if held is None:
        return None
    (first, last), contacts = held
    return sum(measure(run, _one(contact.state), first, last).losses for contact in contacts)


def _held_fraction(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    held = _held(run, platform, window)
    if held is None:
        return 0.0 if platform.contacts else None
    (first, last), contacts = held
    rows = held_rows = 0
    for ticks, states in aligned(run, [contact.state for contact in contacts], first, last):
        rows += ticks.size
        held_rows += int(np.count_nonzero(np.logical_and.reduce([s != 0 for s in states])))
    return held_rows / rows if rows else None


def _force_ripple(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    return _over_forces(run, platform, window, "std", max)


def _grip_force(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    return _over_forces(run, platform, window, "mean", min)


def _over_forces(
    run: Run,
    platform: RecordedPlatform,
    window: TickRange | None,
    statistic: str,
    choose: Callable[[list[float]], float],
) -> float | None:
    held = _held(run, platform, window)
    if held is None:
        return None
    (first, last), contacts = held
    found: list[float] = [
        getattr(measure(run, _one(contact.normal_force), first, last).statistics, statistic)
        for contact in contacts
        if contact.normal_force is not None
    ]
    return choose(found) if found else None


def _drift(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    return _over_copies(run, platform, window, slice(0, 2), "maximum")


def _drift_rms(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    return _over_copies(run, platform, window, slice(0, 2), "rms")


def _drift_angle(run: Run, platform: RecordedPlatform, window: TickRange | None) -> float | None:
    return _over_copies(run, platform, window, slice(2, 3), "maximum")


def _over_copies(
    run: Run, platform: RecordedPlatform, window: TickRange | None, parts: slice, statistic: str
) -> float | None:
    first, last = window or (0, run.ticks)
    found: list[float] = []
    for one, other in combinations(platform.copies, 2):
        target = Target("", platform.poses[one][parts], platform.poses[other][parts], is_norm=True)
        found.append(getattr(measure(run, target, first, last).statistics, statistic))
    return max(found) if found else None


def _box_displacement(
    run: Run, platform: RecordedPlatform, window: TickRange | None
) -> float | None:
    first, last = window or (0, run.ticks)
    found: list[float] = []
    for pose in platform.poses.values():
        start: list[float] | None = None
        for _, values in aligned(run, pose[:2], first, last):
            start = start or [float(value[0]) for value in values]
            found.append(
                float(np.hypot(values[0] - start[0], values[1] - start[1]).max(initial=0.0))
            )
    return max(found) if found else None


def _wall_penetration(
    run: Run, platform: RecordedPlatform, window: TickRange | None
) -> float | None:
    first, last = window or (0, run.ticks)
    found = [
        measure(run, _one(name), first, last).statistics.maximum
        for name in platform.depths.values()
    ]
    return max(found) if found else None


def _one(name: str) -> Target:
    return Target(name, (name,))


def _ever(run: Run, contact: Contact) -> bool:
    return any(bool(block.any()) for block in run[contact.state].blocks())


SCENARIO_MEASURES: dict[str, ScenarioMeasure] = {
    "contact_losses": ScenarioMeasure(
        "",
        "contacts that ended in the hold phase, over all fingers and copies",
        _contact_losses,
        of_hold_phase=True,
    ),
    "held_fraction": ScenarioMeasure(
        "1",
        "share of the hold phase in which every finger is in contact",
        _held_fraction,
        of_hold_phase=True,
    ),
    "grip_force": ScenarioMeasure(
        "N",
        "mean normal force in the hold phase, of the weakest contact",
        _grip_force,
        of_hold_phase=True,
    ),
    "force_ripple": ScenarioMeasure(
        "N",
        "rms deviation of the normal force from its mean in the hold phase, of the worst contact",
        _force_ripple,
        of_hold_phase=True,
    ),
    "drift": ScenarioMeasure("m", "largest distance between two copies of the box", _drift),
    "drift_rms": ScenarioMeasure("m", "rms distance between two copies of the box", _drift_rms),
    "drift_angle": ScenarioMeasure("rad", "largest angle between two copies", _drift_angle),
    "box_displacement": ScenarioMeasure(
        "m", "largest distance of the box from where it began", _box_displacement
    ),
    "wall_penetration": ScenarioMeasure(
        "m", "depth of the deepest corner in a wall", _wall_penetration
    ),
}
