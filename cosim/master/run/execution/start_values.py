"""The cells of a run before anything is computed."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.assemble import Assembly
from cosim.master.components.interface import has_cells
from cosim.master.components.parameters import element_start
from cosim.master.kernel.program import Program


class StartValues:
    """Writes start values into a program's cells, kept for further runs that start from them."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._kept: NDArray[np.int64] | None = None
        self._kept_of: Assembly | None = None

    def fill(self, assembly: Assembly) -> None:
        """Give every variable, dial and held value of a bundle what it starts from."""
        program, before = self._program, self._kept_of
        program.texts.table.clear()
        self._kept_of = assembly
        if self._kept is not None and before is not None and _start_alike(before, assembly):
            program.cells[:] = self._kept
            return
        self._write(assembly)
        if not program.texts.are_there:
            self._kept = program.cells.copy()

    def _write(self, assembly: Assembly) -> None:
        program = self._program
        for name, participant in assembly.participants.items():
            for variable in participant.interface.variables.values():
                if has_cells(variable):
                    values = participant.start.get(variable.name) or element_start(variable)
                    if variable.type.is_text:
                        values = [program.texts.number_of(value) for value in values]
                    program.view(name, variable.name).reshape(-1)[:] = values
        program.turning.fill_start_values()
        program.fill_latched()
        for number, bundle in enumerate(assembly.wiring.bundles):
            held = assembly.layout.held[number]
            for index, entry in enumerate(bundle.entries):
                if entry.target is not None:
                    start = program.cells[assembly.layout.of(entry.target)]
                    program.cells[held + index] = start


def _start_alike(one: Assembly, other: Assembly) -> bool:
    if one.participants is not other.participants:
        for name, each in other.participants.items():
            before = one.participants[name].start
            if each.start is not before and each.start != before:
                return False
    if one.knobs is other.knobs:
        return True
    starts = [{n: k.start for n, k in each.knobs.all.items()} for each in (one, other)]
    return starts[0] == starts[1]
