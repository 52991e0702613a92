"""Verdicts: whether what was measured is what was expected, or why nobody can say that it is."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cosim.report.expectation import COMPARISONS, Expectation
from cosim.report.measures import SCENARIO_MEASURES, Inspection
from cosim.report.runaway import Runaway
from cosim.report.verdict.lack import lack_of
from cosim.report.window import MEASURES, Window, measure


@dataclass(frozen=True, slots=True)
class Verdict:
    """What was measured: every value lies between ``low`` and ``high``, which may be equal."""

    expectation: Expectation
    low: float
    high: float
    passed: bool
    lacking: str = ""
    """Why it is not met whatever was measured; NaN where nothing was."""

    def __str__(self) -> str:
        asked = self.expectation
        name = f"{asked.text} ({asked.label})" if asked.label else asked.text
        limit = " to ".join(f"{value:g}" for value in asked.limit)
        unit = f" {asked.unit}" if asked.unit not in {"", "1"} else ""
        measured = self._measured(unit)
        found = ", but ".join(part for part in (measured, self.lacking) if part)
        return f"{name}: {asked.predicate} {limit}{unit}, measured {found}"

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        asked = self.expectation
        measured = None if math.isnan(self.low) else [self.low, self.high]
        return {
            "target": asked.text,
            "label": asked.label,
            "predicate": asked.predicate,
            "threshold": list(asked.limit) if asked.comparison == "within" else asked.limit[0],
            "measured": measured[0] if measured and self.low == self.high else measured,
            "unit": asked.unit,
            "passed": self.passed,
            "lacking": self.lacking or None,
        }

    def _measured(self, unit: str) -> str:
        if math.isnan(self.low):
            return ""
        if self.low == self.high:
            return f"{self.low:.6g}{unit}"
        return f"{self.low:.6g} to {self.high:.6g}{unit}"


def evaluate(
    measured: Inspection, expectations: Sequence[Expectation], away: Sequence[Runaway] = ()
) -> list[Verdict]:
    """Measure and compare, each in its window; ``away`` are the signals that ran away."""
    meant = meant_to_run_away(expectations)
    unmeant = {each.signal for each in away if each.signal not in meant}
    return [_evaluate(measured, expectation, away, unmeant) for expectation in expectations]


def meant_to_run_away(expectations: Sequence[Expectation]) -> set[str]:
    """The signals of which an expectation says how far or how fast they run away."""
    targets = [each.target for each in expectations if each.is_of_divergence]
    return {name for target in targets if target is not None for name in target.signals}


def _evaluate(
    measured: Inspection, asked: Expectation, away: Sequence[Runaway], unmeant: set[str]
) -> Verdict:
    look = _of_the_run if asked.target is None else _of_signals
    low, high, lacking = look(measured, asked)
    lacking = lacking or _cut_short(measured, asked) or _ran_away(measured, asked, away, unmeant)
    met = COMPARISONS[asked.comparison](low, high, asked.limit)
    return Verdict(asked, low, high, met and not lacking, lacking)


def _of_the_run(measured: Inspection, asked: Expectation) -> tuple[float, float, str]:
    found = measured.value(asked.text, asked.window)
    if found is not None and math.isfinite(found):
        return found, found, ""
    lacking = measured.lack(asked.text, asked.window)
    return math.nan, math.nan, lacking or "nothing in this window"


def _of_signals(measured: Inspection, asked: Expectation) -> tuple[float, float, str]:
    assert asked.target is not None
    run = measured.run
    first, last = asked.window or (0, run.ticks)
    window = (
        measured.window(asked.target, first, last)
        if asked.frequency is None
        else measure(run, asked.target, first, last, asked.frequency)
    )
    samples = MEASURES[asked.measure].samples if asked.measure else 1
    if window.rows < samples or not window.is_finite:
        return math.nan, math.nan, lack_of(run, asked.target, first, last, samples)
    if not asked.measure:
        return window.minimum, window.maximum, ""
    value = MEASURES[asked.measure](window)
    if math.isfinite(value):
        return value, value, ""
    return math.nan, math.nan, f"nothing in this window: {_untold(window, asked)}"


def _untold(window: Window, asked: Expectation) -> str:
    reason = "" if asked.frequency is None else window.untold
    return reason or f"its {window.rows} samples tell no {asked.measure}"


def _cut_short(measured: Inspection, asked: Expectation) -> str:
    """That the run ended before the window did.

    A window without an end lasts to that of the run, which is its own where all went well: a model
    may ask for the end early.
    """
    run = measured.run
    until: float | None = asked.until
    if until is None and run.manifest:
        ending: Mapping[str, Any] = run.manifest.get("exit") or {"status": 1}
        planned: Mapping[str, Any] = run.manifest.get("scenario") or {}
        until = planned.get("ticks", math.inf) if ending.get("status") else None
    if until is None or run.ticks >= until:
        return ""
    return f"the run ended at {run.span[1]:g} s, before the window did"


def _ran_away(
    measured: Inspection, asked: Expectation, away: Sequence[Runaway], unmeant: set[str]
) -> str:
    """That what is judged ran away before the window's end, where that is not what was meant."""
    if asked.is_of_divergence or not away:
        return ""
    if asked.target is not None:
        names = set(asked.target.signals)
    else:
        names = unmeant.union(SCENARIO_MEASURES[asked.text].reads(measured.platform))
    last = measured.run.ticks if asked.window is None else asked.window[1]
    return next((str(each) for each in away if each.tick < last and each.signal in names), "")
