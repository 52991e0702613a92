"""Measured values and their limits in words, for every page alike."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from cosim.thesis.claims.verdict import Decided
from cosim.thesis.expected.predictions import PREDICTIONS


def number(value: float | Sequence[float] | None, unit: str) -> str:
    """A measured value with its unit, in millimetres and milliradians where it is small."""
    if value is None:
        return "nothing"
    values = [value] if isinstance(value, int | float) else list(value)
    prefix, factor = _scale(max(abs(one) for one in values if math.isfinite(one)), unit)
    text = " to ".join(f"{one * factor:.4g}" for one in values)
    return text if unit in {"", "1"} else f"{text} {prefix}{unit}"


def limit(entry: Mapping[str, Any]) -> str:
    """The expectation as a phrase: ``below 0.2 N``."""
    comparison = str(entry["predicate"]).rpartition("_")[2]
    measure = str(entry["predicate"]).rpartition("_")[0].replace("_", " ")
    phrase = {"within": "from", "equals": "exactly"}.get(comparison, comparison)
    return f"{measure} {phrase} {number(entry['threshold'], entry['unit'])}".strip()


def _scale(size: float, unit: str) -> tuple[str, float]:
    return ("m", 1e3) if unit in {"m", "rad"} and 0.0 < size < 0.5 else ("", 1.0)


def origins(item: Decided) -> list[str]:
    """Where a statement's limits come from, each once."""
    labels = dict.fromkeys((one.evidence.scenario, one.evidence.label) for one in item.measured)
    return list(dict.fromkeys(PREDICTIONS[label].sentence for label in labels))


def command(file: str, sets: Sequence[str]) -> str:
    """What runs the same again."""
    quoted = "".join(f" --set '{one}'" for one in sets)
    return f"cohaptic run {file}{quoted}"
