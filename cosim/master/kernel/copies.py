"""Operations that carry values from cell to cell: along wires, and from events to outputs."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable

from cosim.master.assembly.layout import Layout
from cosim.master.assembly.wiring import Wire, Wiring
from cosim.master.kernel.codes import OperationKind
from cosim.master.kernel.structures import ConversionStruct, OperationStruct
from cosim.master.kernel.written import WrittenOperation, with_table


class Copies:
    """The wires of a plan, by where they end."""

    def __init__(self, wiring: Wiring, layout: Layout) -> None:
        self._layout = layout
        self._wires: dict[tuple[str, str], list[Wire]] = {}
        for wire in wiring.wires:
            key = (wire.target.component, wire.target.variable)
            self._wires.setdefault(key, []).append(wire)

    def into(self, unit: str, names: Iterable[str | int]) -> Iterable[WrittenOperation]:
        """What brings values into inputs: plain copies in one operation, conversions in another."""
        wires = [wire for name in names for wire in self._wires.get((unit, str(name)), [])]
        pairs = [
            (self._layout.of(wire.source), self._layout.into(wire.target))
            for wire in wires
            if wire.is_plain
        ]
        if pairs:
            yield with_table(OperationKind.COPY, sorted(pairs))
        converted = [wire for wire in wires if not wire.is_plain]
        if converted:
            table = (ConversionStruct * len(converted))(
                *(
                    ConversionStruct(
                        self._layout.of(wire.source),
                        self._layout.into(wire.target),
                        wire.from_integer,
                        wire.gain,
                        wire.offset,
                    )
                    for wire in converted
                )
            )
            operation = OperationStruct(
                kind=OperationKind.CONVERT, cell_count=len(converted), table=ctypes.addressof(table)
            )
            yield WrittenOperation(operation, (table,))

    def latched(self, unit: str, sizes: Iterable[tuple[str, int]]) -> Iterable[WrittenOperation]:
        """What was read at events becomes what the FMU puts out; names with their sizes."""
        pairs = [
            (self._layout.latched[unit, name] + i, self._layout.cells[unit, name] + i)
            for name, size in sorted(sizes)
            for i in range(size)
        ]
        if pairs:
            yield with_table(OperationKind.COPY, pairs)
