"""The tables of a run's page, as rows of text."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cosim.base.meaning import Meaning
from cosim.record.reader import Run
from cosim.record.statistics import ColumnSummary
from cosim.report.measures import SCENARIO_MEASURES
from cosim.report.quantities import human

AT_LIMIT = 0.999
"""Share of its limit from which a force is at it."""

Row = tuple[str, ...]


def verdict_rows(content: Mapping[str, Any]) -> list[Row]:
    """What was expected, what was measured, and whether that is met."""
    return [
        (
            each["label"] or each["target"],
            f"{each['predicate']} {_expected(each)}",
            human(each["measured"], each["unit"]),
            "met" if each["passed"] else _missed(each),
        )
        for each in content["expectations"]
    ]


def _missed(verdict: Mapping[str, Any]) -> str:
    lacking = verdict.get("lacking")  # summaries of 0.1.0 have none
    return f"NOT MET: {lacking}" if lacking else "NOT MET"


def measure_rows(content: Mapping[str, Any]) -> list[Row]:
    """What the scenario's measures say."""
    return [
        (
            name.replace("_", " "),
            human(value, SCENARIO_MEASURES[name].unit),
            SCENARIO_MEASURES[name].description,
        )
        for name, value in content["measures"].items()
    ]


def channel_table(content: Mapping[str, Any]) -> dict[str, Any] | None:
    """Packets of each direction, by what became of them."""
    channels: Mapping[str, Mapping[str, int]] = content["channels"]
    if not channels:
        return None
    keys = list(next(iter(channels.values())))
    rows = [(name, *(str(counts[key]) for key in keys)) for name, counts in channels.items()]
    return {"heading": ("", *(key.replace("_", " ") for key in keys)), "rows": rows}


def deadline_table(content: Mapping[str, Any]) -> dict[str, Any] | None:
    """Lateness of a paced run: numbers, a histogram's bars, and why deadlines were lost."""
    found: Mapping[str, Any] | None = content["deadlines"]
    if not found:
        return None
    rows = [
        (key.replace("_", " "), seconds(value) if isinstance(value, float) else str(value))
        for key, value in found.items()
        if isinstance(value, int | float | str)
    ]
    why: Mapping[str, Mapping[str, Any]] = found.get("causes") or {}
    causes = [(cause, str(of["misses"]), seconds(of["seconds"])) for cause, of in why.items()]
    histogram: Sequence[tuple[float, int]] = found.get("histogram") or ()
    bars = [(float(below), int(count)) for below, count in histogram]
    most = max((math.log1p(count) for _, count in bars), default=0.0) or 1.0
    return {
        "rows": rows,
        "causes": causes,
        "bars": [
            {
                "below": seconds(below),
                "count": count,
                "height": round(70 * math.log1p(count) / most),
            }
            for below, count in bars
        ],
    }


def saturation_rows(run: Run, scene: Mapping[str, Any] | None) -> list[Row]:
    """How long each finger's force was at its limit."""
    rows: list[Row] = []
    for finger in (scene or {}).get("fingers", ()):
        force: Sequence[str] = finger.get("force") or ()
        limit = finger.get("limit")
        if not limit or len(force) != 2 or any(name not in run for name in force):
            continue
        at_limit = total = 0
        blocks = zip(*(run[name].blocks() for name in force), strict=True)
        for x, y in blocks:
            at_limit += int(np.count_nonzero(np.hypot(x, y) >= AT_LIMIT * limit))
            total += x.size
        share = at_limit / total if total else 0.0
        rows.append((finger["name"], human(limit, "N"), human(share, "1")))
    return rows


def energy_rows(run: Run, summaries: Mapping[str, ColumnSummary]) -> list[Row]:
    """What the users have put into each port: least, and at the end."""
    return [
        (
            name,
            human(summaries[name].statistics.minimum, "J"),
            human(float(run[name][-1:][0]), "J"),
        )
        for name in used_ports(run, summaries)
    ]


def used_ports(run: Run, summaries: Mapping[str, ColumnSummary]) -> list[str]:
    """Energies of ports, without those of peers who never touched, or are not there."""
    found: list[str] = []
    for name, signal in run.signals.items():
        if signal.meaning is not Meaning.PORT_ENERGY or name not in summaries:
            continue
        ends = summaries[name].statistics
        is_idle = ends.minimum == ends.maximum == 0.0
        if signal.group.rows and not (is_idle and signal.belongs_to.peer is not None):
            found.append(name)
    return found


def provenance_rows(run: Run, digest: str) -> list[Row]:
    """What would be needed to run it again."""
    manifest = run.manifest
    scenario = _of(manifest, "scenario")
    versions = _of(manifest, "versions")
    rows: list[Row] = [
        ("scenario", str(scenario.get("name", ""))),
        ("seed", str(scenario.get("seed", ""))),
        ("base rate", f"{float(run.base_rate):g} Hz"),
        ("ticks", str(run.ticks)),
        ("digest", digest),
        ("started", str(manifest.get("started", ""))),
        ("versions", ", ".join(f"{name} {version}" for name, version in versions.items())),
        ("machine", " ".join(str(v) for v in _of(manifest, "platform").values())),
    ]
    timing = _of(manifest, "timing")
    if "real_time_factor" in timing:
        rows.append(("speed", f"{timing['real_time_factor']:.3g} × real time"))
    rows += [
        (f"FMU {each['source']}", f"FMI {each['fmi']}, SHA-256 {each['sha256'][:16]}…")
        for each in {
            each["sha256"]: each
            for each in _of(manifest, "components").values()
            if each.get("sha256")
        }.values()
    ]
    files = _of(manifest, "files")
    return rows + [(file, f"SHA-256 {sha[:16]}…") for file, sha in files.items()]


def _of(manifest: Mapping[str, Any], part: str) -> Mapping[str, Any]:
    """A part of the manifest; empty where it has none, as that of an older run."""
    return manifest.get(part) or {}


def _expected(verdict: Mapping[str, Any]) -> str:
    threshold: float | Sequence[float] = verdict["threshold"]
    ends = threshold if isinstance(threshold, Sequence) else (threshold,)
    return " to ".join(human(each, verdict["unit"]) for each in ends)


def seconds(value: float) -> str:
    """A time (s), as a person reads it."""
    for factor, unit in ((1.0, "s"), (1e3, "ms")):
        if abs(value) * factor >= 1.0:
            return f"{value * factor:.3g} {unit}"
    return f"{value * 1e6:.3g} µs"
