"""Copies of one shared object: what two components simulate together has to be the same to both."""

from __future__ import annotations

from collections.abc import Generator, Mapping
from typing import Any, cast

from cosim.base.component import Causality
from cosim.base.document.show import show
from cosim.base.meaning import OF_OWN_DEVICE, Meaning
from cosim.master.components.participant import Participant
from cosim.scenario import Scenario


def differing_copies(scenario: Scenario, participants: Mapping[str, Participant]) -> Generator[str]:
    """A sentence for each parameter in which two peers of one model differ.

    Peers are components of the same FMU, one of which tells the other its state. What stands for a
    component's own device may differ.
    """
    for first, second in sorted(_peers(scenario, participants)):
        ours, theirs = _shared(participants[first]), _shared(participants[second])
        for name in ours:
            if ours[name] != theirs[name]:
                yield (
                    f"{first} and {second} simulate copies of one object, but {name} is "
                    f"{_said(ours[name])} in {first} and {_said(theirs[name])} in {second}: "
                    "set it in both"
                )


def _peers(scenario: Scenario, participants: Mapping[str, Participant]) -> set[tuple[str, str]]:
    found: set[tuple[str, str]] = set()
    for connection in scenario.connections:
        source = participants.get(connection.source.component)
        target = participants.get(connection.target.component)
        if source is None or target is None or source is target:
            continue
        if source.fmu is None or target.fmu is None or source.fmu.sha256 != target.fmu.sha256:
            continue
        if _takes_a_peers_state(target, connection.target.path):
            found.add((min(source.name, target.name), max(source.name, target.name)))
    return found


def _takes_a_peers_state(participant: Participant, path: str) -> bool:
    inside = (f"{path}.", f"{path}[")
    return any(
        variable.meaning_of() is Meaning.PEER_STATE
        for name, variable in participant.interface.variables.items()
        if name == path or name.startswith(inside)
    )


def _shared(participant: Participant) -> dict[str, list[Any]]:
    """Parameters by name, with their defaults, without those of its own device."""
    found: dict[str, list[Any]] = {}
    for name, variable in participant.interface.variables.items():
        is_own = variable.meaning_of() in OF_OWN_DEVICE
        if variable.causality is Causality.PARAMETER and not is_own:
            given = participant.parameters.get(name)
            found[name] = list(given) if given is not None else _default(variable.start)
    return found


def _default(start: Any) -> list[Any]:
    return list(cast("list[Any]", start)) if isinstance(start, list | tuple) else [start]


def _said(values: list[Any]) -> str:
    return show(values[0] if len(values) == 1 else values)
