"""The summary of a run: one JSON object (``summary.json``, ``--json``), and the same as text.

Everything in the object is in SI units; docs/record.md lists its members.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosim.base.meaning import Meaning
from cosim.record.reader import Run
from cosim.record.signals import RecordedSignal
from cosim.record.statistics import ColumnSummary
from cosim.report.expectation import Expectation
from cosim.report.judged import judge
from cosim.report.measures import SCENARIO_MEASURES
from cosim.report.quantities import fitted, human, table

SUMMARY_FILE = "summary.json"

HEADLINES = (
    (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE),
    (Meaning.NORMAL_FORCE,),
    (Meaning.TIP_POSITION,),
    (Meaning.MOTOR_TORQUE,),
    (Meaning.AXIS_POSITION, Meaning.AXIS_VELOCITY, Meaning.AXIS_FORCE),
)
"""What a reader looks at first, in this order; of fingers, the own ones."""

_LAST = ("wall_penetration", "saturated_ticks")
HEADLINE_ROWS = 16
SHOWN = 4
"""Runaway signals that are named; once a loop diverges, all of it does."""


@dataclass(frozen=True, slots=True)
class Summary:
    """``content`` is the JSON object."""

    content: Mapping[str, Any]

    @property
    def status(self) -> int:
        """The exit status that the run stands for: also 1 where an expectation is not met."""
        return int(self.content["status"])

    def text(self, width: int | None = None) -> str:
        """For a terminal of so many columns or a log, without colour."""
        parts = [_head(self.content), _measures(self.content), _traffic(self.content, width)]
        parts += [_signals(self.content, width), _verdicts(self.content)]
        parts += [_runaways(self.content), _end(self.content)]
        return fitted("\n\n".join(part for part in parts if part), width)


def summarise(
    run: Run,
    expectations: Sequence[Expectation] = (),
    summaries: Mapping[str, ColumnSummary] | None = None,
) -> Summary:
    """Summarise a run from its record and its manifest.

    ``summaries`` are what the recorder accumulated; without them the whole file is read.
    """
    if summaries is None:
        summaries = {name: signal.summary() for name, signal in run.signals.items()}
    statistics = {name: each.statistics for name, each in summaries.items()}
    extremes = {
        name: (math.nan, math.nan) if each.missing else (each.minimum, each.maximum)
        for name, each in statistics.items()
    }
    judged = judge(run, expectations, extremes)
    verdicts, away = judged.verdicts, judged.runaways
    manifest = run.manifest
    ending = manifest.get("exit") or {"status": 1, "message": "The run was cut off."}
    content: dict[str, Any] = {
        "scenario": manifest.get("scenario", {}).get("name", ""),
        "title": manifest.get("scenario", {}).get("title", ""),
        "run": str(run.folder),
        "status": ending["status"] or int(not judged.is_good),
        "message": ending["message"],
        "ticks": run.ticks,
        "planned_ticks": manifest.get("scenario", {}).get("ticks"),
        "base_rate": str(run.base_rate),
        "simulated_time": float(run.ticks / run.base_rate),
        **(manifest.get("timing") or {}),
        "recorded": _recorded(run),
        "measures": judged.measures,
        "expectations": [verdict.as_dict() for verdict in verdicts],
        "passed": not judged.failures if verdicts else None,
        "failures": judged.failures,
        "runaways": [str(each) for each in away],
        "channels": manifest.get("channels") or {},
        "deadlines": manifest.get("deadlines"),
        "warnings": manifest.get("warnings") or {},
        "headlines": headlines(run.signals),
        "signals": {
            name: {"unit": signal.unit} | statistics[name].as_dict()
            for name, signal in run.signals.items()
        },
    }
    return Summary(content)


def read_summary(folder: Path) -> Summary | None:
    """The summary that a run left in its folder, if it did."""
    try:
        return Summary(json.loads((folder / SUMMARY_FILE).read_text(encoding="utf-8")))
    except (OSError, json.JSONDecodeError):
        return None


def facts(content: Mapping[str, Any]) -> str:
    """One line: how long, what the measures say, how the expectations stand, how it ended."""
    parts = [numbers(content), *content.get("runaways", ())[:1]]
    if content["expectations"]:
        parts.append(met(content))
    if content["message"]:
        parts.append(content["message"].splitlines()[0])
    return " · ".join(parts)


def numbers(content: Mapping[str, Any]) -> str:
    """How long it was, and what the measures say."""
    parts = [f"{content['simulated_time']:g} s"]
    for name in ("contact_losses", "held_fraction", "force_ripple", "drift", *_LAST):
        found = content["measures"].get(name)
        if found is not None and (found or name != "saturated_ticks"):
            value = human(content["measures"][name], SCENARIO_MEASURES[name].unit)
            parts.append(f"{name.replace('_', ' ')} {value}")
    return " · ".join(parts)


def outcome(content: Mapping[str, Any]) -> str:
    """How it ended; else what ran away, and how the expectations stand."""
    if content["message"]:
        return str(content["message"])
    away = len(content["runaways"])
    parts = [f"{away} signal{'s' if away > 1 else ''} ran away"] if away else []
    parts += [met(content)] if content["expectations"] else []
    return " · ".join(parts) or ("Ran to its end" if content["status"] == 0 else "Failed")


def met(content: Mapping[str, Any]) -> str:
    """How many of the expectations are met."""
    total = len(content["expectations"])
    return f"{total - len(content['failures'])} of {total} expectations met"


def headlines(signals: Mapping[str, RecordedSignal]) -> list[str]:
    """The signals that a reader looks at first; the first few of an unknown scenario."""
    chosen = [
        name
        for meanings in HEADLINES
        for name, signal in signals.items()
        if signal.meaning in meanings and signal.belongs_to.peer is None
    ]
    return (chosen or list(signals))[:HEADLINE_ROWS]


def _recorded(run: Run) -> dict[str, int]:
    groups = run.groups.values()
    return {
        "signals": sum(len(group.signals) for group in groups),
        "rows": sum(group.rows for group in groups),
        "bytes": sum(8 * group.rows * (len(group.signals) + 1) for group in groups),
    }


def _head(content: Mapping[str, Any]) -> str:
    recorded = content["recorded"]
    facts = [f"{content['simulated_time']:g} s simulated"]
    if "wall_time" in content:
        facts[0] += f" in {content['wall_time']:.3g} s"
        facts.append(f"{content['real_time_factor']:.3g} × real time")
    size = f"{recorded['signals']} signals, {recorded['bytes'] / 1e6:.3g} MB"
    facts.append(size if recorded["signals"] else "nothing is recorded")
    if content.get("peak_memory"):
        facts.append(f"{content['peak_memory'] / 1e6:.0f} MB of memory")
    return f"{content['title'] or content['scenario']}\n  {' · '.join(facts)}"


def _measures(content: Mapping[str, Any]) -> str:
    rows = [
        (name.replace("_", " "), human(value, SCENARIO_MEASURES[name].unit), "")
        for name, value in content["measures"].items()
    ]
    descriptions = [SCENARIO_MEASURES[name].description for name in content["measures"]]
    if not rows:
        return ""
    width = max(len(row[0]) for row in rows)
    return "\n".join(
        f"  {name.ljust(width)}  {value:>9}  {description}"
        for (name, value, _), description in zip(rows, descriptions, strict=True)
    )


def _traffic(content: Mapping[str, Any], width: int | None) -> str:
    lines: list[str] = []
    if content["channels"]:
        keys = list(next(iter(content["channels"].values())))
        rows = [("packets", "", *(key.replace("_", " ") for key in keys))]
        rows += [
            (name, "", *(str(counts[key]) for key in keys))
            for name, counts in content["channels"].items()
        ]
        lines.append(table(rows, width=width))
    if content["deadlines"]:
        lines.append(f"  deadlines: {_deadlines(content['deadlines'])}")
    return "\n".join(lines)


def _signals(content: Mapping[str, Any], width: int | None) -> str:
    signals = content["signals"]
    rows: list[tuple[str, ...]] = [("signal", "unit", "min", "max", "mean", "rms")]
    for name in content["headlines"]:
        found = signals[name]
        numbers = (found["minimum"], found["maximum"], found["mean"], found["rms"])
        shown = ("–" if value is None else f"{value:.4g}" for value in numbers)
        rows.append((name, found["unit"], *shown))
    return table(rows, width=width) if len(rows) > 1 else ""


def _verdicts(content: Mapping[str, Any]) -> str:
    verdicts = content["expectations"]
    if not verdicts:
        return ""
    lines = [f"  {met(content)}"]
    lines += [f"  FAILED  {failure}" for failure in content["failures"]]
    return "\n".join(lines)


def _runaways(content: Mapping[str, Any]) -> str:
    away: list[str] = content.get("runaways") or []  # summaries of 0.1.0 have none
    more = [f"  and {len(away) - SHOWN} more ran away"] if len(away) > SHOWN else []
    return "\n".join([*(f"  {sentence}" for sentence in away[:SHOWN]), *more])


def _end(content: Mapping[str, Any]) -> str:
    state = {True: "recorded in", False: "what was reached is in"}[not content["message"]]
    return f"  {state} {content['run']}"


def _deadlines(facts: Mapping[str, Any]) -> str:
    """Counts as they are, latenesses (s) in microseconds; the histogram stays in the manifest."""
    shown = [
        f"{key.replace('_', ' ')} {value * 1e6:.0f} µs"
        if isinstance(value, float)
        else f"{key.replace('_', ' ')} {value}"
        for key, value in facts.items()
        if isinstance(value, int | float | str)
    ]
    return ", ".join(shown)
