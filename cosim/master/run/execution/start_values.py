"""The cells of a run before anything is computed."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.assemble import Assembly
from cosim.master.components.interface import has_cells
from cosim.master.components.parameters import element_start
from cosim.master.components.participant import Values
from cosim.master.kernel.program import Program


class StartValues:
    """Writes start values into a program's cells, kept for further runs that start from them."""

    def __init__(self, program: Program) -> None:
        self._program = program
        self._kept: tuple[Mapping[str, Values], NDArray[np.int64]] | None = None

    def fill(self, assembly: Assembly) -> None:
        """Give every variable, dial and held value of a bundle what it starts from."""
        program = self._program
        start = {name: each.start for name, each in assembly.participants.items()}
        start["knobs"] = {".".join(name): k.start for name, k in assembly.knobs.all.items()}
        program.texts.table.clear()
        if self._kept is not None and self._kept[0] == start and not program.texts.are_there:
            program.cells[:] = self._kept[1]
            return
        self._write(assembly)
        self._kept = start, program.cells.copy()

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
