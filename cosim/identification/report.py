"""The result as a table for people and as plain data for programs."""

from __future__ import annotations

from collections.abc import Sequence
from math import log10
from typing import Any

from cosim.identification.fit import Length
from cosim.identification.results import CONFIDENCE, Estimate, Identified
from cosim.identification.whiteness import LEVEL

_SCALES = {
    "J": (1e6, "mg.m2"),
    "home": (1e6, "mg.m2"),
    "M": (1e3, "g"),
    "phi": (1e3, "g"),
    "coulomb": (1e3, "mN.m"),
    "viscous": (1e6, "uN.m.s/rad"),
    "bias": (1e3, "mN.m"),
    "latency": (1e3, "ms"),
    "offset": (1e3, "mrad"),
    "gain": (1.0, "1"),
}


def lines(found: Identified) -> list[str]:
    """The table, what the rows were, and what is assumed."""
    counts, tick = found.counts, found.runs[0].tick
    names = ", ".join(each.name for each in found.runs)
    said = [f"{names}: {counts.used} of {counts.rows} rows used ({counts.used * tick:.1f} s)"]
    said += [f"  left out: {what}" for what in _left_out(found)]
    said += ["", *_table(found.estimates, tick), ""]
    said.append(
        f"The model explains {found.explained:.2%} of the torque; "
        f"condition {found.fit.condition:.0f}."
    )
    said.append(_white(found))
    said += [_wrong(each) for each in found.wrong_lengths]
    said += [f"Assumed: {each}." for each in assumptions(found)]
    return said


def plain(found: Identified) -> dict[str, Any]:
    """Everything as plain data, SI units."""
    counts, white = found.counts, found.white
    return {
        "ok": found.is_whole,
        "confidence": CONFIDENCE,
        "estimates": {
            each.name: {
                "value": each.value,
                "low": each.low,
                "high": each.high,
                "unit": each.unit,
                "description": each.description,
                "reason": each.reason or None,
            }
            for each in found.estimates
        },
        "runs": [
            {"name": each.name, "digest": each.digest, "date": each.date, "payload": each.payload}
            for each in found.runs
        ],
        "rows": {
            "all": counts.rows,
            "used": counts.used,
            "saturated": counts.saturated,
            "stale": counts.stale,
            "without_output": counts.without_output,
            "clock_gaps": counts.gaps,
        },
        "pose": list(found.pose),
        "condition": found.fit.condition,
        "explained": found.explained,
        "lengths": {
            each.name: {"share": each.share, "deviation": each.deviation}
            for each in found.fit.lengths
        },
        "white": {
            "is_white": white.is_white,
            "chance": list(white.chance),
            "lags": white.lags.tolist(),
            "correlations": white.correlations.tolist(),
        },
        "assumed": assumptions(found),
    }


def assumptions(found: Identified) -> list[str]:
    """What the result stands on besides the records."""
    bar = found.described.bar
    lengths = f"links of {bar.proximal * 1e3:g} and {bar.distal * 1e3:g} mm"
    said = [
        f"{lengths}, motors {bar.base * 1e3:g} mm apart, as the device file or the model has them"
    ]
    if found.alike:
        said.append("both sides have the same inertia (--sides apart asks the runs)")
    if found["gain_1"].value is None:
        said.append(
            "the motors give the torque that is commanded; inertia and friction scale with it"
        )
    if all(each.payload is None for each in found.runs):
        said.append("nothing was on the tip (--payload RUN=MASS says otherwise)")
    return said


def _left_out(found: Identified) -> list[str]:
    counts = found.counts
    return [
        f"{number} rows {why}"
        for number, why in (
            (counts.saturated, "at a joint's torque limit"),
            (counts.stale, "whose sample was not new"),
            (counts.without_output, "without output"),
            (counts.gaps, "where the clock has a gap"),
        )
        if number
    ]


def _table(estimates: Sequence[Estimate], tick: float) -> list[str]:
    rows = [("", "value", f"{CONFIDENCE:.0%} interval", "")]
    for each in estimates:
        factor, unit = scale(each.name)
        interval = ""
        if each.low is not None and each.high is not None:
            low, high = each.low * factor, each.high * factor
            interval = f"{number(low, high - low)} … {number(high, high - low)}"
        value = "–"
        if each.value is not None and each.low is not None and each.high is not None:
            value = f"{number(each.value * factor, (each.high - each.low) * factor)} {unit}"
            if each.name == "latency":
                value += f" ({each.value / tick:.2f} ticks)"
        elif interval:
            interval += f" {unit}"
        words = each.description
        if each.reason:
            words += f": not identifiable from these runs, {each.reason}"
        rows.append((each.name, value, interval, words))
    widths = [max(len(row[at]) for row in rows) for at in range(3)]
    return [
        "  ".join(
            [*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[3]]
        ).rstrip()
        for row in rows
    ]


def scale(name: str) -> tuple[float, str]:
    """Factor and unit in which a quantity is shown."""
    return _SCALES[name.partition("_")[0]]


def number(value: float, width: float) -> str:
    """A value with two digits of its interval's width."""
    digits = 3 if width <= 0.0 else max(0, 1 - int(log10(width) // 1))
    return f"{value:.{digits}f}"


def _wrong(length: Length) -> str:
    return (
        f"The geometry is NOT that of the device: what is left of the torque hangs together with "
        f"the {length.name} length ({abs(length.share) / length.deviation:.0f} standard "
        "deviations; one wrong length shows in others, too). Do not trust the values."
    )


def _white(found: Identified) -> str:
    chances = " and ".join(f"{each:.2g}" for each in found.white.chance)
    if found.white.is_white:
        return f"The residual is white: chance gives more correlation with {chances} (joints 1, 2)."
    return (
        f"The residual is NOT white (chance {chances}, below {LEVEL:g}): these runs hold something "
        "that the model does not, such as a hand on the handle, a wrong payload or geometry, or a "
        "slope. Do not trust the values."
    )
