"""What a run is worth: its measures, the verdicts of its expectations, and what ran away.

One definition for a run from a file and for one in memory.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cosim.record.reader import Run
from cosim.report.expectation import Expectation
from cosim.report.measures import SCENARIO_MEASURES, Extremes, Inspection, TickRange
from cosim.report.runaway import Runaway, runaways
from cosim.report.verdict.evaluate import Verdict, evaluate, meant_to_run_away


@dataclass(frozen=True, slots=True)
class Judged:
    """What was found in one run."""

    measures: dict[str, float]
    """Every scenario measure that applies (SI units)."""
    verdicts: list[Verdict]
    runaways: list[Runaway]
    inspection: Inspection
    """What was looked at, for those that want to know more."""

    @property
    def failures(self) -> list[str]:
        """A sentence for each expectation that was not met."""
        return [str(verdict) for verdict in self.verdicts if not verdict.passed]

    @property
    def is_good(self) -> bool:
        """Whether all expectations were met and nothing ran away."""
        return not self.runaways and all(verdict.passed for verdict in self.verdicts)


def judge(
    run: Run, expectations: Sequence[Expectation], extremes: Mapping[str, Extremes]
) -> Judged:
    """Measure and judge a run; ``extremes`` are those of each recorded signal.

    Who expects a signal to grow, or to be as large as only what ran away is, is its judge.
    """
    inspection = Inspection(run, extremes)
    meant = meant_to_run_away(expectations)
    away = runaways(run, extremes)
    return Judged(
        measures=take_measures(inspection, expectations),
        verdicts=evaluate(inspection, expectations, away),
        runaways=[each for each in away if each.signal not in meant],
        inspection=inspection,
    )


def take_measures(measured: Inspection, expectations: Sequence[Expectation]) -> dict[str, float]:
    """Every scenario measure that applies, in the window of the scenario's own expectation of it.

    Measures of the hold phase without a window of their own share the one given for
    ``contact_losses``, so that all speak of the same time.
    """
    if not measured.platform.is_there:
        return {}
    windows: dict[str, TickRange] = {}
    for expectation in expectations:
        if expectation.target is None and expectation.window is not None:
            windows.setdefault(expectation.text, expectation.window)
    hold = windows.get("contact_losses")
    found: dict[str, float] = {}
    for name, measure in SCENARIO_MEASURES.items():
        value = measured.value(name, windows.get(name, hold if measure.of_hold_phase else None))
        if value is not None and not math.isnan(value):
            found[name] = value
    return found
