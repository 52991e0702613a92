"""Which inputs of a station wait for what the link knows of a peer: weight, validity, age."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from cosim.base.component import Causality
from cosim.base.meaning import Meaning
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import PacketFact, Signal, Wire
from cosim.scenario import Reference
from cosim.station.signals import StationSignals, reference

PEER_FACTS = {
    Meaning.PEER_WEIGHT: "weight",
    Meaning.PEER_VALID: "valid",
    Meaning.PEER_AGE: "age",
}
"""What the link says of a peer to the inputs that mean it."""

FIRST = 1
"""The peer that a variable is of where it does not say."""


def peer_inputs(
    assembly: Assembly, signals: StationSignals, number: int, wires: Sequence[Wire]
) -> Iterator[tuple[str, Reference]]:
    """Of bundle ``number``, whose values go along ``wires``: facts and the inputs they go to."""
    driven = assembly.wiring.connection_of
    slots = dict.fromkeys(
        (wire.target.component, signals.slot(wire.target).peer or FIRST) for wire in wires
    )
    for component, place in slots:
        interface = assembly.participants[component].interface
        for path, element in interface.elements.items():
            variable = interface.variables[element.variable]
            meaning = variable.meaning_of(element.index)
            fact = None if meaning is None else PEER_FACTS.get(meaning)
            if fact is None or variable.causality is not Causality.INPUT:
                continue
            if (variable.slot_of(element.index).peer or FIRST) != place:
                continue
            if Signal(component, element.variable, element.index) not in driven:
                yield fact, reference(component, path)
    for wire in assembly.wiring.wires:
        source = wire.source
        if isinstance(source, PacketFact) and source.bundle == number:
            yield source.name, reference(wire.target.component, signals.path(wire.target))
