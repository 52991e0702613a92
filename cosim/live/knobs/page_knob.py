"""A slider or switch of the page, and what it turns in each station's panel."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import ceil, floor
from typing import Any, Literal

Rounding = Literal["none", "up", "down"]


@dataclass(frozen=True, slots=True, kw_only=True)
class KnobWire:
    """One thing that a knob turns: a value of a station's panel is ``factor`` times the knob's.

    ``rounding`` rounds half of the knob's value first, as a round-trip delay is shared out.
    """

    station: str
    target: str
    factor: float = 1.0
    rounding: Rounding = "none"

    def value(self, turned: float) -> float:
        """What the panel shows."""
        if self.rounding == "none":
            return self.factor * turned
        return self.factor * (ceil if self.rounding == "up" else floor)(turned / 2)


@dataclass(frozen=True, slots=True, kw_only=True)
class PageKnob:
    """A slider of the page; values as the page shows them."""

    key: str
    label: str
    unit: str
    minimum: float
    maximum: float
    step: float
    start: float
    wires: tuple[KnobWire, ...] = field(repr=False)
    choices: tuple[str, ...] = ()
    """What a switch's values 0, 1 … are called; empty for a slider."""


def knob_of(told: Mapping[str, Any]) -> PageKnob:
    """What ``dataclasses.asdict`` made of a knob, after a way as JSON."""
    given = dict(told)
    wires = tuple(KnobWire(**wire) for wire in given.pop("wires"))
    choices = tuple(given.pop("choices"))
    return PageKnob(**given, wires=wires, choices=choices)


def places(knobs: list[PageKnob]) -> dict[str, list[tuple[PageKnob, KnobWire]]]:
    """By station, what each value of its panel turns, in order."""
    found: dict[str, list[tuple[PageKnob, KnobWire]]] = {}
    for knob in knobs:
        for wire in knob.wires:
            found.setdefault(wire.station, []).append((knob, wire))
    return found
