"""The order in which the parts of a run come to life, and in which they are closed."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager

from cosim.base.component import Component
from cosim.base.errors import RunError
from cosim.master.assembly.assemble import Assembly
from cosim.master.fmu.instance import Fmu
from cosim.master.kernel.program import Program
from cosim.master.run.execution.components import RunningComponents
from cosim.master.run.execution.fmus import RunningFmus, Told
from cosim.master.run.execution.kernel_run import KernelRun
from cosim.master.run.execution.start_values import StartValues
from cosim.master.run.outcome import Outcome
from cosim.master.run.whereabouts import Whereabouts

ALL_TOGETHER = ("all components together", "exchanging their first values")


class LifeCycle:
    """The parts of a simulation, from one run of ``assembly`` to the next."""

    def __init__(self, assembly: Assembly, program: Program, whereabouts: Whereabouts) -> None:
        self.assembly = assembly
        self.fmus = RunningFmus(assembly, whereabouts)
        self.components = RunningComponents(program, whereabouts)
        self.kernel_run = KernelRun(assembly, program, self.fmus, self.components.all)
        self.is_running = False
        """Between a start and the closing of the components."""
        self._program = program
        self._whereabouts = whereabouts
        self._start_values = StartValues(program)
        self._compiled: bool | None = None
        """Whether the program that was written records; ``None`` before there is one."""

    @property
    def has_started(self) -> bool:
        """Whether there was a run before."""
        return self._compiled is not None

    @property
    def state(self) -> tuple[Assembly, Program, Mapping[str, Fmu], Mapping[str, Component]]:
        """Everything that a state between two ticks consists of."""
        return self.assembly, self._program, self.fmus.all, self.components.all

    def guarding(self) -> AbstractContextManager[None]:
        """Protect the process while FMUs are called; see ``RunningFmus.guarding``."""
        return self.fmus.guarded

    def start(self, end: int, told: Told, *, recorded: bool, rehearsal: bool) -> None:
        """Have everything at tick 0 of a run that ends at tick ``end``.

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: it failed.
        """
        self._start_values.fill(self.assembly)
        is_restarted = self.fmus.prepare(end, told)
        self._compile(recorded=recorded, is_restarted=is_restarted)
        self._program.turning.write_events(self._program.kernel, self.assembly.knobs.turns)
        self.components.start(self.assembly, told, rehearsal=rehearsal)
        self.fmus.enter_initialisation(end, told)
        told(*ALL_TOGETHER)
        self._whereabouts.clear()
        with self.guarding():
            self.kernel_run.initialise()
        self.fmus.leave_initialisation(self.kernel_run.begin_events, told)
        self.is_running = True

    def take(self, assembly: Assembly) -> None:
        """Have another assembly of the same plan from now on."""
        self.assembly = self.fmus.assembly = assembly
        self.kernel_run = KernelRun(assembly, self._program, self.fmus, self.components.all)

    def rewind(self, assembly: Assembly) -> None:
        """Be before the start of another run, of an assembly of the same plan."""
        self.is_running = False
        self.components.forget()
        self.take(assembly)
        self._program.rewind(assembly.wiring)
        self._program.turning.rewind(assembly.knobs.all)

    def reached(
        self, wall_time: float, *, interrupted: bool, ended_by: str, briefly: bool = False
    ) -> Outcome:
        """How far the run came; ``ended_by`` is the sentence of who asked for its end.

        What was counted on the way is left out with ``briefly``.
        """
        program = self._program
        # The tick in which a model comes to its end has been recorded.
        ticks = program.kernel.tick + bool(ended_by)
        if briefly:
            return Outcome(
                ticks=ticks, wall_time=wall_time, interrupted=interrupted, ended_by=ended_by
            )
        return Outcome(
            ticks=ticks,
            wall_time=wall_time,
            interrupted=interrupted,
            channels=program.packets.counts(),
            warnings=program.warnings(),
            ended_by=ended_by,
            said=self.fmus.said(),
        )

    def close_components(self) -> None:
        """Close what is not an FMU; may be called more than once."""
        self.is_running = False
        self.components.close()

    def close(self) -> None:
        """Close everything; may be called more than once."""
        self.close_components()
        self.fmus.close()

    def _compile(self, *, recorded: bool, is_restarted: bool) -> None:
        """Write the program, once: it is the same for every run of this simulation."""
        if self._compiled is not None:
            if self._compiled is not recorded:
                raise RunError("One simulation is either recorded in all of its runs, or in none.")
            if is_restarted:
                self._program.set_warnings({})
            else:
                self._program.refresh()
            return
        plan = self.assembly.plan if recorded else self.assembly.plan.without_recording()
        columns, texts = self.assembly.columns, self.assembly.text_columns
        self._program.compile(plan, self.fmus.all, columns, texts)
        self._compiled = recorded
