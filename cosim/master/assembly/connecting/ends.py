"""Both ends of a wire, and their names."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from cosim.base.component import Variable
from cosim.base.quantities.units import Unit
from cosim.master.assembly.wiring import PacketFact, Signal
from cosim.master.components.interface import Element, Interface
from cosim.scenario import Connection


@dataclass(frozen=True, slots=True)
class Pair:
    """One source element and the input element it drives."""

    source: Signal | PacketFact
    source_variable: Variable
    source_unit: Unit | None
    target: Signal
    target_variable: Variable
    target_unit: Unit | None


def join(source: Interface, there: Element, target: Interface, here: Element) -> Pair:
    """An element of one interface drives one of another."""
    return Pair(
        Signal(source.component, there.variable, there.index),
        source.variables[there.variable],
        source.unit(there.variable),
        Signal(target.component, here.variable, here.index),
        target.variables[here.variable],
        target.unit(here.variable),
    )


def name_of(interfaces: Mapping[str, Interface], signal: Signal) -> str:
    """Component, variable and index of a signal."""
    interface = interfaces[signal.component]
    return f"{signal.component}.{interface.element_name(Element(signal.variable, signal.index))}"


def source_name(interfaces: Mapping[str, Interface], connection: Connection, pair: Pair) -> str:
    """The source of a pair as a sentence names it."""
    source = pair.source
    return name_of(interfaces, source) if isinstance(source, Signal) else str(connection.source)
