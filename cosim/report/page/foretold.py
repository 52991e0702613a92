"""Theory beside measurement: what chapters 3 to 6 say of a scenario, and what its run did.

Of a grasp the normal forces are looked at, in the hold phase; of a single axis the speeds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cosim.base.meaning import Meaning
from cosim.record.reader import Run
from cosim.report.measures import Inspection, TickRange
from cosim.report.quantities import human
from cosim.report.target import aligned
from cosim.theory.stability.told import ToldLoop

LAST = 0.1
"""Share of a run at whose end it is asked whether it still moves."""
SHORTEST = 64
"""Fewest rows whose spectrum is looked at."""

Row = tuple[str, ...]
Values = NDArray[np.float64]


def foretold_rows(told: Sequence[ToldLoop], run: Run) -> list[Row]:
    """What is looked at, what the theory says of it, what was measured; empty without theory."""
    known = [loop for loop in told if not loop.refusal]
    if not known:
        return []
    measured = _of_forces(run) or _of_speeds(run) or ("nothing of it was recorded", "")
    rows: list[Row] = []
    for number, loop in enumerate(known):
        name = f"{loop.name}: " if loop.name else ""
        seen = measured if number == 0 else ("", "")
        verdict = "stable" if loop.is_stable else "unstable"
        radius = f"{verdict}, spectral radius {loop.radius:.4g} over {loop.period * 1e3:.3g} ms"
        rows += [
            (f"{name}is it calm?", radius, seen[0]),
            (f"{name}slowest motion", _motion(loop), seen[1]),
        ]
    return rows


def foretold_notes(told: Sequence[ToldLoop]) -> list[str]:
    """What was left out, and why nothing is said where nothing is."""
    refused = [
        f"{f'{loop.name}: ' if loop.name else ''}the theory says nothing here. {loop.refusal}"
        for loop in told
        if loop.refusal
    ]
    return list(dict.fromkeys([*refused, *(note for loop in told for note in loop.notes)]))


def _motion(loop: ToldLoop) -> str:
    rate = math.log(loop.growth)
    swings = f", at {loop.frequency:.3g} Hz" if loop.frequency > 0.0 else ", without swinging"
    if rate == 0.0:
        return f"neither grows nor dies away{swings}"
    how = "dies away" if rate < 0.0 else "grows"
    return f"{how} by a factor of e in {human(1.0 / abs(rate), 's')}{swings}"


def _of_forces(run: Run) -> tuple[str, str] | None:
    """Ripple of the worst contact in the hold phase, and where its spectrum is highest."""
    measured = Inspection(run)
    ripple = measured.value("force_ripple")
    phase = measured.hold_phase
    if ripple is None or phase is None:
        return None
    window, contacts = phase
    names = [contact.normal_force for contact in contacts if contact.normal_force is not None]
    forces = [_values(run, name, window) for name in names]
    worst = int(np.argmax([force.std() for force in forces]))
    found = f"force ripple {human(ripple, 'N')} ({names[worst]})"
    period = float(run[names[worst]].group.period / run.base_rate)
    frequency = _frequency(forces[worst], period)
    return found, "" if frequency is None else f"ripples most at {frequency:.3g} Hz"


def _of_speeds(run: Run) -> tuple[str, str] | None:
    """The greatest speed at the end of the run beside that of all of it."""
    names = [n for n, s in run.signals.items() if s.meaning is Meaning.AXIS_VELOCITY]
    if not names:
        return None
    end = (int(run.ticks * (1.0 - LAST)), run.ticks)
    whole, last = (
        max(float(np.abs(_values(run, name, ticks)).max(initial=0.0)) for name in names)
        for ticks in ((0, run.ticks), end)
    )
    return (
        f"at most {human(last, 'm/s')} in the last tenth of the run",
        f"at most {human(whole, 'm/s')} in all of it",
    )


def _values(run: Run, name: str, window: TickRange) -> Values:
    pieces = [values[0] for _, values in aligned(run, [name], *window)]
    return np.concatenate(pieces).astype(np.float64) if pieces else np.zeros(0)


def _frequency(values: Values, period: float) -> float | None:
    """Where a signal swings most (Hz), by its windowed spectrum; the mean and its drift apart."""
    if values.size < SHORTEST or not np.isfinite(values).all():
        return None
    time = np.linspace(-1.0, 1.0, values.size)
    rest = values - np.polyval(np.polyfit(time, values, 1), time)
    power = np.abs(np.fft.rfft(rest * np.hanning(values.size)))
    return float(np.argmax(power[1:]) + 1) / (values.size * period) if power.any() else None
