"""The architectures that a scenario holds, each by itself, and what the theory says of them."""

from __future__ import annotations

from dataclasses import replace

from cosim.analysis.loop import read_loop
from cosim.base.errors import CohapticError
from cosim.scenario import Scenario
from cosim.theory.models.parameters import Parameters
from cosim.theory.stability.told import ToldLoop, tell

WORLDS = {
    "distributed": {"distributed_workstation"},
    "centralized": {"central_server", "remote_client"},
}
"""The models of each architecture."""
TURNED = "What is turned while it runs is left as it stands at the start."


def worlds_of(scenario: Scenario) -> list[str]:
    """The architectures whose models the scenario has; none of a single axis."""
    present = {part.source for part in scenario.components.values() if part.is_bundled}
    return [name for name, models in WORLDS.items() if models & present]


def alone(scenario: Scenario, name: str) -> Scenario:
    """The scenario with one architecture's models alone."""
    others = {model for world, models in WORLDS.items() if world != name for model in models}
    kept = {
        key: part
        for key, part in scenario.components.items()
        if not (part.is_bundled and part.source in others)
    }
    links = tuple(
        link
        for link in scenario.connections
        if link.source.component in kept and link.target.component in kept
    )
    return replace(scenario, components=kept, connections=links)


def tell_of(scenario: Scenario) -> tuple[ToldLoop, ...]:
    """What chapters 3 to 6 say of each architecture of a scenario, in closed form.

    Where they have no such loop, the refusal is what is told.
    """
    names = worlds_of(scenario)
    if len(names) < 2:
        return (_told("", scenario),)
    return tuple(_told(name, alone(scenario, name)) for name in names)


def _told(name: str, scenario: Scenario) -> ToldLoop:
    try:
        loop = read_loop(scenario)
    except CohapticError as error:
        return ToldLoop(name, refusal=str(error))
    notes = dict.fromkeys(loop.notes)
    if scenario.events:
        notes |= {TURNED: None}
    model = Parameters(loop.architecture, loop.values, {}, users=loop.users).model()
    return tell(name, model, loop.timing, tuple(notes))
