"""The components of a run that are objects of this process: Python, devices, played recordings."""

from __future__ import annotations

from contextlib import suppress

from cosim.base.component import Component
from cosim.master.assembly.assemble import Assembly
from cosim.master.components.interface import has_cells
from cosim.master.components.participant import Participant, setup_of
from cosim.master.components.python_component import sentences
from cosim.master.kernel.program import Program
from cosim.master.run.execution.fmus import Told
from cosim.master.run.whereabouts import Whereabouts


class RunningComponents:
    """They are taken, given their views of the cells, initialised and closed."""

    def __init__(self, program: Program, whereabouts: Whereabouts) -> None:
        self.all: dict[str, Component] = {}
        """By name; those that were closed stay until ``forget``."""
        self._program = program
        self._whereabouts = whereabouts
        self._started: list[tuple[str, Component]] = []

    def start(self, assembly: Assembly, told: Told, *, rehearsal: bool) -> None:
        """Initialise each one, or with ``rehearsal`` do what needs nothing outside the process.

        Raises:
            InputError: one refuses its parameters.
            RunError: one failed.
        """
        for name, participant in assembly.participants.items():
            if participant.supply is None:
                continue
            component = participant.supply.take()
            self.all[name] = component
            self._started.append((name, component))
            views = {
                causality: {
                    variable.name: self._program.view(name, variable.name)
                    for variable in participant.interface.variables.values()
                    if variable.causality == causality
                    and has_cells(variable)
                    and not variable.type.is_text
                }
                for causality in ("input", "output")
            }
            for turned in sorted(participant.interface.knobs):
                views["input"][turned] = self._program.view(name, turned)
            told(name, "being initialised")
            self._whereabouts.note(name, "its initialisation")
            begin = component.rehearse if rehearsal else component.initialise
            with sentences(name, "while it was initialised"):
                self._bind_texts(component, participant)
                begin(setup_of(assembly.scenario, participant), views["input"], views["output"])

    def _bind_texts(self, component: Component, participant: Participant) -> None:
        """Give a component its views of texts, where it has any."""
        inputs, outputs = (
            {
                variable.name: self._program.texts.view(participant.name, variable.name)
                for variable in participant.interface.variables.values()
                if variable.causality == causality and variable.type.is_text
            }
            for causality in ("input", "output")
        )
        if inputs or outputs:
            component.bind_texts(inputs, outputs)

    def close(self) -> None:
        """Close those that were started, the last one first; may be called more than once."""
        for name, component in reversed(self._started):
            # Every component must be reached.
            with self._whereabouts.aside(), suppress(Exception):
                self._whereabouts.note(name, "its closing")
                component.close()
        self._started.clear()

    def forget(self) -> None:
        """Close all and have none any more."""
        self.close()
        self.all.clear()
