"""The server's side of the knobs: what pages turn goes into the rings of the panels."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import Any, cast

from cosim.live.knobs.page_knob import PageKnob, places
from cosim.live.panel import KNOBS
from cosim.realtime.ring import Ring


class Panels:
    """The values of all knobs, and the rings that take them."""

    def __init__(self, knobs: list[PageKnob], rings: Mapping[str, Ring]) -> None:
        self._knobs = {knob.key: knob for knob in knobs}
        self._places, self._rings = places(knobs), rings
        self._values = {knob.key: knob.start for knob in knobs}

    def told(self) -> list[dict[str, Any]]:
        """For the page."""
        return [
            {
                "key": knob.key,
                "label": knob.label,
                "unit": knob.unit,
                "minimum": knob.minimum,
                "maximum": knob.maximum,
                "step": knob.step,
                "value": self._values[knob.key],
                "choices": knob.choices,
            }
            for knob in self._knobs.values()
        ]

    def hear(self, wish: Any) -> bool:
        """Turn what a page asks for (values by key); whether anything was turned."""
        if not isinstance(wish, Mapping):
            return False
        before = dict(self._values)
        for key, value in cast("Mapping[Any, Any]", wish).items():
            knob = self._knobs.get(key)
            if knob is None or type(value) not in {int, float} or not isfinite(value):
                continue
            if knob.choices and value not in range(len(knob.choices)):
                continue
            if knob.minimum <= value <= knob.maximum:
                self._values[knob.key] = float(value)
        if self._values == before:
            return False
        for station, ring in self._rings.items():
            row = [0.0] * KNOBS
            for index, (knob, wire) in enumerate(self._places[station]):
                row[index] = wire.value(self._values[knob.key])
            ring.write(row)
        return True
