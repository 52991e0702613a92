"""One HTML page: each statement of the thesis beside what was measured, with the figures."""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from cosim.thesis.experiments import Ran
from cosim.thesis.findings import BeyondPart
from cosim.thesis.statements import Decided

CAPTIONS = {
    "8.1": "Figure 8.1: grasp and carry, distributed against the remote user of the centralized "
    "controller, same couplers, one network sample of delay.",
    "8.3": "Figure 8.3: a sine of 0.05 m at 2 rad/s against a constant opposing force. The net "
    "force is what both fingers give together, each on its own copy of the box.",
    "8.4": "Figure 8.4: pushing the box against a stiff wall with the pushing halves of "
    "1.5 sin 3t N.",
    "7.4": "A finger hits the box at 0.3 m/s with a wall behind it, with and without the "
    "moment-cancellation state of figure 7.4.",
}


def write_page(
    path: Path,
    decided: Sequence[Decided],
    runs: Mapping[str, Ran],
    figures: Mapping[str, Path],
    beyond: BeyondPart | None = None,
) -> None:
    """Write the page; the figures are inside it, so that it can be sent around alone.

    ``beyond`` is the second part, what lies past the thesis.
    """
    from jinja2 import Environment

    template = files("cosim.thesis").joinpath("page.html.j2").read_text(encoding="utf-8")
    environment = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True)
    verdicts = [item.verdict for item in decided]
    html = environment.from_string(template).render(
        number=number,
        limit=limit,
        decided=decided,
        runs=runs,
        figures=[(CAPTIONS.get(name, name), _embedded(file)) for name, file in figures.items()],
        beyond=beyond and beyond.decided,
        findings=beyond.findings(_embedded) if beyond else (),
        counts={verdict: verdicts.count(verdict) for verdict in sorted(set(verdicts))},
    )
    path.write_text(html, encoding="utf-8")


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


def _embedded(file: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(file.read_bytes()).decode("ascii")
