"""What was turned by hand while a scenario ran, as events of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from cosim.base.component import VariableType
from cosim.master.assembly.knobs import Knobs, Name, Turn
from cosim.scenario import Event, Reference, Scenario


def with_events(scenario: Scenario, knobs: Knobs, by_hand: Sequence[Turn]) -> Scenario:
    """The scenario with another event for each turn that came into force.

    Of what is turned several times before it comes into force, the last counts; an event of the
    scenario comes after what was done by hand before the same tick.
    """
    if not by_hand:
        return scenario
    last: dict[tuple[Name, int], Turn] = {}
    for turn in sorted([*by_hand, *knobs.turns], key=lambda turn: turn.tick):
        tick = knobs.effective(turn.name, turn.tick)
        if tick < scenario.ticks:
            last[turn.name, tick] = turn
    events = [
        Event(
            tick=turn.tick,
            target=Reference(component=turn.name[0], path=turn.name[1]),
            value=_value(knobs, turn),
        )
        for turn in sorted(last.values(), key=lambda turn: turn.tick)
    ]
    return replace(scenario, events=tuple(events))


def _value(knobs: Knobs, turn: Turn) -> Any:
    variable = knobs.all[turn.name].variable
    elements = turn.elements
    if variable.type is VariableType.BOOLEAN:
        elements = tuple(map(bool, elements))
    return elements if variable.shape else elements[0]
