"""What is laid over a scenario so that its knobs can be turned.

Each station has a ``panel`` whose values drive the dials of its outgoing channels and the tunable
parameters of its workstation; the scenario is compiled for the knobs' ranges.
"""

from __future__ import annotations

from typing import Any

from cosim.live.hands import PANEL
from cosim.live.knobs.page_knob import PageKnob, places
from cosim.live.panel import KNOBS
from cosim.scenario import Scenario


def with_panels(scenario: Scenario, knobs: list[PageKnob]) -> dict[str, Any]:
    """The document to lay over the scenario, as YAML holds it."""
    components: dict[str, Any] = {}
    connections: list[str] = []
    for station, wires in places(knobs).items():
        rate = next(p for p in scenario.components.values() if p.station == station)
        values = [0.0] * KNOBS
        for index, (knob, wire) in enumerate(wires):
            values[index] = wire.value(knob.start)
            connections.append(f"panel_{station}.value[{index + 1}] -> {wire.target}")
        components[f"panel_{station}"] = {
            "python": PANEL,
            "station": station,
            "rate": rate.rate_name or float(rate.rate),
            "parameters": {"start": values},
        }
    ranges: dict[str, Any] = {}
    for knob in knobs:
        for wire in knob.wires:
            ends = sorted((wire.value(knob.minimum), wire.value(knob.maximum)))
            unit = " s" if wire.target.endswith((".delay", ".jitter")) else 0
            least, most = (f"{end!r}{unit}" if unit else end for end in ends)
            ranges[wire.target] = {"minimum": least, "maximum": most}
    return {"components": components, "connections": connections, "knobs": ranges}


def others_events(scenario: Scenario, knobs: list[PageKnob]) -> list[dict[str, Any]]:
    """What the scenario turns itself, as YAML holds it, but for what people turn now."""
    turned = {wire.target for knob in knobs for wire in knob.wires}
    return [
        {
            "at": f"{event.tick} ticks",
            "set": {str(event.target): f"{event.value} s" if seconds else event.value},
        }
        for event in scenario.events
        if str(event.target) not in turned
        for seconds in [str(event.target).endswith((".delay", ".jitter"))]
    ]
