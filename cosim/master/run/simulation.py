"""A run: components started, ticks run in chunks by the kernel, rows handed over, all closed."""

from __future__ import annotations

import ctypes
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import dataclass, field
from functools import partial
from types import TracebackType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Component
from cosim.base.errors import EndAsked, InputError, RunError
from cosim.base.recording import Forgetful, RecordGroup, Rows, Sink
from cosim.base.system.garbage import without_collecting
from cosim.master.assembly.assemble import Assembly, Only, put_together
from cosim.master.channels.packets import PacketCount
from cosim.master.components.interface import has_cells
from cosim.master.components.parameters import element_start
from cosim.master.components.participants import Factory, Participant, Values, setup_of
from cosim.master.components.python_component import sentences
from cosim.master.fmu.instance import Fmu
from cosim.master.fmu.isolation.isolated import ProcessEnded
from cosim.master.fmu.log import Said
from cosim.master.fmu.refusal import placed_refusal
from cosim.master.fmu.surroundings import Surroundings
from cosim.master.kernel.native import library
from cosim.master.kernel.program import INITIAL, Program
from cosim.master.kernel.structures import KernelOutcome as Stop
from cosim.master.run import branch_point, checkpoint
from cosim.master.run.branch_point import BranchPoint
from cosim.master.run.diagnosis import explain, moment
from cosim.master.run.guard import StatusReturnedError, guarded
from cosim.master.run.interrupt import Wish, wish_to_stop
from cosim.master.run.replay import with_events
from cosim.master.run.restart import Restart, Times
from cosim.master.run.snapshot import Snapshot
from cosim.master.run.whereabouts import Whereabouts
from cosim.scenario import Kind, Scenario

FIRST_CHUNK, LONGEST_CHUNK = 1, 1024
_UNGUARDED = nullcontext()
ALL_TOGETHER = ("all components together", "exchanging their first values")
CHUNK_SECONDS = (0.005, 0.05)
"""A chunk grows while it takes less than the first and shrinks where it takes more than the second,
so that Ctrl-C is heard soon."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How far a run came, and what was counted on the way."""

    ticks: int
    wall_time: float
    """Time spent in the loop (s), without start-up and shut-down."""
    interrupted: bool
    channels: Mapping[str, PacketCount] = field(default_factory=dict[str, PacketCount])
    warnings: Mapping[str, int] = field(default_factory=dict[str, int])
    """Warnings that FMUs returned, by component."""
    ended_by: str = ""
    """The sentence of the model that asked for the end, which is a good one."""
    said: Mapping[str, tuple[Said, ...]] = field(default_factory=dict[str, "tuple[Said, ...]"])
    """What FMUs said that was not well, by component."""


class Drive(Protocol):
    """Runs a program in place of the loop by chunks; the pace is its own, the numbers are not."""

    def __call__(
        self,
        program: Program,
        components: Mapping[str, Component],
        groups: Sequence[RecordGroup],
        sink: Sink | None,
        *,
        end: int,
        wish: Wish,
    ) -> Stop:
        """Run until tick ``end``, a wish, or what the kernel comes back for otherwise."""
        ...


Told = Callable[[str, str], None]
"""Told a component's name, and what is about to be done with it."""
Pause = Callable[[], None]
"""Called between two ticks."""

Progress = Callable[[int, float], None]
"""Told the ticks done and the loop's wall time (s), a few times a second."""


def assemble(
    scenario: Scenario,
    instances: Mapping[str, Component] | None = None,
    kinds: Mapping[Kind, Factory] | None = None,
    whereabouts: Whereabouts | None = None,
    only: Only | None = None,
) -> Simulation:
    """Read, check, wire and plan a scenario; no native code has run yet.

    ``instances`` holds components that exist already, by name; ``kinds`` makes those of kinds that
    the master does not know, such as playback. ``whereabouts`` is where the run says what it does.
    ``only`` chooses among what the scenario records.

    Raises:
        InputError: a problem, or ``InputErrors`` for several, each with its place.
    """
    with without_collecting():
        return Simulation(put_together(scenario, instances, kinds, only), whereabouts)


class Simulation:
    """One run of a scenario; a context manager that closes every component on every exit path."""

    def __init__(self, assembly: Assembly, whereabouts: Whereabouts | None = None) -> None:
        self.assembly = assembly
        self._whereabouts = whereabouts or Whereabouts()
        self.program = Program(
            assembly.parts,
            assembly.wiring,
            assembly.layout,
            assembly.clock,
            kernel=self._whereabouts.kernel,
            knobs=assembly.knobs.all,
        )
        self.outcome = Outcome(ticks=0, wall_time=0.0, interrupted=False)
        """What was reached, also after an error."""
        self._fmus: dict[str, Fmu] = {}
        self._components: dict[str, Component] = {}
        self._handlers: dict[int, Callable[[int], None]] = {}
        self._started: list[Component] = []
        self._failed: set[str] = set()
        self._wall_time = 0.0
        self._rows: dict[int, Rows] = {}
        self._restored: Snapshot | None = None
        self._is_running = False
        self._end = 0
        self.died = ""
        """The sentence of an isolated FMU whose process ended when it was closed."""
        self._pauses: dict[int, Pause] = {}
        self._origin: BranchPoint | None = None
        self._chunk = FIRST_CHUNK
        self._restart: Restart | None = None
        self._kept_times: tuple[int, Times] | None = None
        self._start_cells: tuple[Mapping[str, Values], NDArray[np.int64]] | None = None
        self._compiled: bool | None = None
        """Whether the program that was written records; ``None`` before there is one."""

    @property
    def scenario(self) -> Scenario:
        """What runs."""
        return self.assembly.scenario

    @property
    def whereabouts(self) -> Whereabouts:
        """What it is doing, to be read from a process that it was forked from, too."""
        return self._whereabouts

    @property
    def groups(self) -> tuple[RecordGroup, ...]:
        """What will be recorded."""
        return self.assembly.groups

    @property
    def lagging(self) -> tuple[str, ...]:
        """Connections into FMUs without ``feedthrough: true``, which answer a step late."""
        return self.assembly.lagging

    @property
    def notes(self) -> tuple[str, ...]:
        """What is worth telling: unit conversions."""
        return self.assembly.notes

    @property
    def fmu_digests(self) -> dict[str, str]:
        """SHA-256 (hex) of every FMU, by component."""
        return {
            name: each.fmu.sha256
            for name, each in self.assembly.participants.items()
            if each.fmu is not None
        }

    def run(
        self,
        sink: Sink | None = None,
        *,
        progress: Progress | None = None,
        until: int | None = None,
        drive: Drive | None = None,
        pauses: Mapping[int, Pause] | None = None,
        keep_fmus: bool = False,
        mark_at_end: bool = False,
    ) -> Outcome:
        """Run to tick ``until`` (the scenario's end unless given), from ``restore``'s tick or 0.

        Ctrl-C ends the run early; what was reached has been handed to ``sink`` in any case.
        ``drive`` runs the program in place of the loop (``cosim.realtime``) and tells nobody how
        far it is; the numbers are the same. ``pauses`` are called between two ticks, before
        anything of the tick is done by which they are kept; not with ``drive``.
        Every component is closed at the end; with ``keep_fmus`` the FMUs only by ``close``, so
        that one which dies of it finds the record finished. With ``mark_at_end`` nothing is closed,
        and later runs begin where this one ended (``branch``).

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: an FMU returned an error status, put out NaN, or a component failed.
        """
        end = self.scenario.ticks if until is None else until
        interrupted, ended_by = False, ""
        self._pauses = dict(pauses or {})
        try:
            with without_collecting():
                if self._origin is None:
                    last = self.scenario.ticks if mark_at_end else end
                    self._start(last, recorded=sink is not None)
            self.program.texts.record_into(sink)
            if sink is not None:
                sink.begin(self.groups, self.scenario.base_rate)
            with wish_to_stop(self._whereabouts.hear) as wish:
                self._loop(end, sink, progress, drive, wish)
            interrupted = wish.is_made and self.program.kernel.tick < end
            if mark_at_end and not interrupted:
                parts = self.assembly, self.program, self._fmus, self._components
                self._origin = branch_point.mark(*parts)
        except KeyboardInterrupt:
            interrupted = True
        except EndAsked as end_asked:
            ended_by = str(end_asked)
        finally:
            self.outcome = Outcome(
                # The tick in which a model comes to its end has been recorded.
                ticks=self.program.kernel.tick + bool(ended_by),
                wall_time=self._wall_time,
                interrupted=interrupted,
                channels=self.program.packets.counts(),
                warnings=self.program.warnings(),
                ended_by=ended_by,
                said={name: said for name, fmu in self._fmus.items() if (said := fmu.said())},
            )
            if self._origin is None:
                self._close_components()
                if not keep_fmus:
                    self.close()
        return self.outcome

    def branch(self, assembly: Assembly) -> None:
        """Make ready for a run that begins where the one with ``mark_at_end`` ended.

        What channels do from then on is that of ``assembly``: one that ``with_values`` made.

        Raises:
            InputError: there is no such place, or components have other values.
            RunError: a component does not take its state back.
        """
        if self._origin is None:
            raise InputError("No run of this simulation has ended where others could begin.")
        branch_point.check_branch(self._origin, assembly)
        self.assembly = assembly
        self._handlers.clear()
        parts = assembly, self.program, self._fmus, self._components
        branch_point.go_back(self._origin, *parts)

    def renew(self, assembly: Assembly) -> None:
        """Make ready for another run, after one with ``keep_fmus``; nothing of that one is left.

        ``assembly`` is the one that this simulation was made of, or one that ``with_values`` made
        of it: the program stays as it is.

        Raises:
            InputError: it is of another plan.
            RunError: an FMU was lost for good.
        """
        lost = next((name for name, fmu in self._fmus.items() if fmu.is_lost), None)
        if lost is not None:
            raise RunError(f"{lost}: after a fatal status nothing more can be run with it.")
        if assembly.plan is not self.assembly.plan or assembly.layout is not self.assembly.layout:
            raise InputError("A simulation can only be renewed with an assembly of the same plan.")
        self._close_components()
        self._components.clear()
        self._handlers.clear()
        self._restored = None
        self.assembly = assembly
        self.program.rewind(assembly.wiring)
        self.program.turning.rewind(assembly.knobs.all)

    def start(self, until: int | None = None) -> None:
        """Start every component; then ``advance``, ``snapshot`` and ``restore`` as often as wanted.

        For those that record nothing and go on from one state many times. ``until`` is the last
        tick (the scenario's end unless given).

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: it failed.
        """
        with without_collecting():
            self._start(self.scenario.ticks if until is None else until, recorded=False)

    def advance(self, tick: int) -> None:
        """Run on to a tick, after ``start``.

        Raises:
            RunError: an FMU returned an error status, put out NaN, or a component failed.
        """
        self._repeat(tick, None)

    def set(self, values: Mapping[str, Any]) -> None:
        """Turn knobs of the scenario from the next tick on; all of them, or none.

        Keys and values are those of an event: ``{"coupler.stiffness": "400 N/m", "lan.delay": 2}``.
        May be called from any thread. ``replay`` has what was turned, and when.

        Raises:
            InputError: there is no such knob, a connection drives it, or it does not go so far.
        """
        knobs = self.assembly.knobs
        found = [
            entry for key, value in values.items() for entry in knobs.judge(key, value).items()
        ]
        for name, _ in found:
            if driver := knobs.all[name].connection:
                raise InputError(f"{'.'.join(name)} is driven by {driver}")
        self.program.turning.asked.extend((name, tuple(elements)) for name, elements in found)

    def replay(self) -> Scenario:
        """The scenario with everything that ``set`` turned as events: it gives the same run."""
        return with_events(self.scenario, self.assembly.knobs, self.program.turning.by_hand)

    def snapshot(self) -> Snapshot:
        """The state between two ticks: after ``start``, or in one of ``run``'s pauses.

        Raises:
            InputError: a device, or a component without ``save`` and ``load``.
            RunError: a component failed; or nothing runs.
        """
        if not self._is_running:
            raise RunError("Nothing runs of which a snapshot could be taken.")
        return checkpoint.take(self.assembly, self.program, self._fmus, self._components)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot: at once where the run has started, else when it starts.

        An FMU that does not give its state away is run again from tick 0 when the run starts, and
        all values must then be those of the snapshot.

        Raises:
            InputError: it is of another plan, of other components, or beyond the run's end.
            RunError: a component does not take its state back.
        """
        checkpoint.check(self.assembly, snapshot)
        if not self._is_running:
            self._restored = snapshot
            return
        stateless = checkpoint.without_state(self.assembly)
        if stateless:
            raise InputError(
                f"The FMU of {stateless[0]} does not give its state away, so that its run can only "
                "be repeated from tick 0: restore the snapshot before the run starts."
            )
        self._put_back(snapshot)

    @property
    def fmus(self) -> Mapping[str, Fmu]:
        """The FMUs that run, by component; empty before the start."""
        return self._fmus

    @property
    def repeated(self) -> tuple[str, ...]:
        """The components for which ``restore`` runs everything again from tick 0."""
        return checkpoint.without_state(self.assembly)

    def rehearse(self, told: Told) -> None:
        """Start every component up to the first tick; nothing outside of this process is touched.

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: it failed.
        """
        self.program.texts.record_into(None)
        self._start(self.scenario.ticks, recorded=True, rehearsal=told)

    def close(self) -> None:
        """Free every FMU and close every component; may be called more than once."""
        self._close_components()
        self._restart = None
        apart = {fmu.library for fmu in self._fmus.values() if fmu.is_isolated}
        lost = {fmu.library for fmu in self._fmus.values() if fmu.is_lost} - apart
        for name, fmu in self._fmus.items():
            try:
                with self._guarding(fmu):
                    fmu.close(failed=name in self._failed or fmu.library in lost)
            except RunError as error:
                self.died = self.died or str(error)
        self._whereabouts.clear()

    def _close_components(self) -> None:
        self._is_running = False
        for component in reversed(self._started):
            with suppress(Exception):  # every component must be reached
                component.close()
        self._started.clear()

    def __enter__(self) -> Simulation:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
        if kind is None and self.died:
            raise RunError(self.died)

    def _start(self, end: int, *, recorded: bool, rehearsal: Told | None = None) -> None:
        told = rehearsal or _tell_nobody
        self._fill_start_values()
        times = self._times(end)
        restarted = self._restarted(times)
        if restarted is None:
            self._create_fmus(told)
        self._compile(recorded=recorded, is_restarted=restarted is not None)
        self.program.turning.write_events(self.program.kernel, self.assembly.knobs.turns)
        self._start_components(told, rehearsal=rehearsal is not None)
        for name, fmu in self._fmus.items() if restarted is None else ():
            told(name, "entering initialisation mode")
            with placed_refusal(self.scenario, name), self._guarding(fmu):
                fmu.enter_initialisation(*times[name])
        told(*ALL_TOGETHER)
        self._whereabouts.clear()
        with self._guarding(*self._fmus.values()):
            while (stop := self._evaluate(INITIAL)) is Stop.CALL:
                self._serve()
            self._raise_unless_done(stop)
        if restarted is None:
            for name, fmu in self._fmus.items():
                told(name, "leaving initialisation mode")
                with placed_refusal(self.scenario, name), self._guarding(fmu):
                    self._begin_events(name, 0)
                    fmu.exit_initialisation()
                    self._begin_events(name, 1)
        else:
            restarted.leave(self.scenario)
        self._is_running, self._end = True, end
        if self._restored is not None:
            self._go_on(self._restored, recorded=recorded)

    def _begin_events(self, name: str, phase: int) -> None:
        """What an FMU in event mode does before tick 0."""
        self._whereabouts.clear()
        self._raise_unless_done(Stop(self.program.begin_events(name, phase)))

    def _times(self, end: int) -> Times:
        """When the run of each FMU begins and ends (s)."""
        if self._kept_times is None or self._kept_times[0] != end:
            begin = self.assembly.clock.seconds(0)
            # The end of its last step may lie beyond the run's.
            ends = {
                period: self.assembly.clock.seconds(-(-end // period) * period)
                for period in {part.period for part in self.assembly.parts.values()}
            }
            parts = self.assembly.parts
            fmus = (name for name, each in self.assembly.participants.items() if each.fmu)
            self._kept_times = end, {name: (begin, ends[parts[name].period]) for name in fmus}
        return self._kept_times[1]

    def _restarted(self, times: Times) -> Restart | None:
        """The FMUs of the run before, in initialisation mode; ``None`` where that cannot be."""
        if self._restart is None:
            if (
                self._failed
                or not self._fmus
                or not all(f.can_restart for f in self._fmus.values())
            ):
                return None
            self._restart = Restart(self._fmus)
        if not self._failed and self._restart.begin(self.assembly.participants, times):
            return self._restart
        self._restart = None
        return None

    def _go_on(self, snapshot: Snapshot, *, recorded: bool) -> None:
        """Be where a snapshot was taken, be it by running again up to there."""
        if not self.repeated:
            self._put_back(snapshot)
            return
        self._refuse_beyond_end(snapshot)
        self.program.texts.record_into(None)
        self._repeat(snapshot.tick, Forgetful(self.groups) if recorded else None)
        if not checkpoint.same_state(snapshot, self.program):
            raise RunError(
                f"Run again from tick 0, because the FMU of {self.repeated[0]} does not give its "
                f"state away, the run has other values at tick {snapshot.tick} than the snapshot: "
                "one of its components does not compute the same twice."
            )

    def _put_back(self, snapshot: Snapshot) -> None:
        self._refuse_beyond_end(snapshot)
        checkpoint.put_back(snapshot, self.program, self._fmus, self._components)

    def _refuse_beyond_end(self, snapshot: Snapshot) -> None:
        if snapshot.tick > self._end:
            raise InputError(
                f"The snapshot is of tick {snapshot.tick}, but the run ends at tick {self._end}; "
                "give it a longer duration."
            )

    def _repeat(self, tick: int, sink: Sink | None) -> None:
        kernel = self.program.kernel
        while kernel.tick < tick:
            self._run_chunk(kernel.tick, min(tick, kernel.tick + LONGEST_CHUNK), sink)

    def _guarding(self, *fmus: Fmu) -> AbstractContextManager[None]:
        """``_guard``, where there is anything to guard against."""
        own = all(fmu.is_trusted and not fmu.is_isolated for fmu in fmus)
        return _UNGUARDED if own else self._guard(*fmus)

    @contextmanager
    def _guard(self, *fmus: Fmu) -> Generator[None]:
        """Put back what foreign FMUs, one of these, change of what belongs to the process.

        Raises:
            RunError: the process that one of them has for itself has ended.
        """
        foreign = [fmu for fmu in fmus if not fmu.is_trusted]
        before = Surroundings() if foreign else None
        try:
            yield
        except ProcessEnded as ended:
            component, doing = self._whereabouts.sentence(self.scenario)
            self._fmus[component].is_lost = True
            raise RunError(f"{component} {ended.manner} {doing}") from None
        finally:
            for what in before.put_back() if before is not None else ():
                for fmu in foreign:
                    fmu.disturbed(what if len(foreign) == 1 else f"{what} (or another FMU did)")

    def _compile(self, *, recorded: bool, is_restarted: bool) -> None:
        """Write the program, once: it is the same for every run of this simulation."""
        if self._compiled is not None:
            if self._compiled is not recorded:
                raise RunError("One simulation is either recorded in all of its runs, or in none.")
            if is_restarted:
                self.program.set_warnings({})
            else:
                self.program.refresh()
            return
        plan = self.assembly.plan if recorded else self.assembly.plan.without_recording()
        columns, texts = self.assembly.columns, self.assembly.text_columns
        self.program.compile(plan, self._fmus, columns, texts)
        self._compiled = recorded

    def _create_fmus(self, told: Told) -> None:
        for name, fmu in self._fmus.items():
            if not fmu.is_trusted:  # all that share a library, before it is loaded anew
                with self._guarding(fmu):
                    fmu.close(failed=name in self._failed)
        for name, participant in self.assembly.participants.items():
            if participant.fmu is None:
                continue
            is_new = name not in self._fmus
            if is_new:
                self._fmus[name] = Fmu(
                    name,
                    participant.fmu,
                    substeps=participant.substeps,
                    is_trusted=self.scenario.components[name].is_bundled,
                    is_isolated=participant.is_isolated,
                    calling=partial(self._whereabouts.note, name),
                )
            fmu = self._fmus[name]
            told(name, "being instantiated and given its values")
            with placed_refusal(self.scenario, name), self._guarding(fmu):
                if is_new:
                    fmu.instantiate()
                else:
                    fmu.renew(failed=name in self._failed)
                fmu.configure(participant.parameters)
                fmu.set_values(participant.parameters)
                fmu.set_values(participant.start)
        self._failed.clear()

    def _start_components(self, told: Told, *, rehearsal: bool) -> None:
        for name, participant in self.assembly.participants.items():
            if participant.supply is None:
                continue
            component = participant.supply.take()
            self._components[name] = component
            self._started.append(component)
            views = {
                causality: {
                    variable.name: self.program.view(name, variable.name)
                    for variable in participant.interface.variables.values()
                    if variable.causality == causality
                    and has_cells(variable)
                    and not variable.type.is_text
                }
                for causality in ("input", "output")
            }
            for turned in sorted(participant.interface.knobs):
                views["input"][turned] = self.program.view(name, turned)
            told(name, "being initialised")
            self._whereabouts.note(name, "its initialisation")
            begin = component.rehearse if rehearsal else component.initialise
            with sentences(name, "while it was initialised"):
                self._bind_texts(component, participant)
                begin(setup_of(self.scenario, participant), views["input"], views["output"])

    def _bind_texts(self, component: Component, participant: Participant) -> None:
        """Give a Python component its views of texts, where it has any."""
        inputs, outputs = (
            {
                variable.name: self.program.texts.view(participant.name, variable.name)
                for variable in participant.interface.variables.values()
                if variable.causality == causality and variable.type.is_text
            }
            for causality in ("input", "output")
        )
        if inputs or outputs:
            component.bind_texts(inputs, outputs)

    def _fill_start_values(self) -> None:
        """The cells before anything is computed; kept for the next run, if it starts from them."""
        start = {name: each.start for name, each in self.assembly.participants.items()}
        start["knobs"] = {".".join(name): k.start for name, k in self.assembly.knobs.all.items()}
        self.program.texts.table.clear()
        is_known = self._start_cells is not None and self._start_cells[0] == start
        if is_known and not self.program.texts.are_there:
            assert self._start_cells is not None
            self.program.cells[:] = self._start_cells[1]
            return
        self._write_start_values()
        self._start_cells = start, self.program.cells.copy()

    def _write_start_values(self) -> None:
        for name, participant in self.assembly.participants.items():
            for variable in participant.interface.variables.values():
                if has_cells(variable):
                    values = participant.start.get(variable.name) or element_start(variable)
                    if variable.type.is_text:
                        values = [self.program.texts.number_of(value) for value in values]
                    self.program.view(name, variable.name).reshape(-1)[:] = values
        self.program.turning.fill_start_values()
        self.program.fill_latched()
        for number, bundle in enumerate(self.assembly.wiring.bundles):
            held = self.assembly.layout.held[number]
            for index, entry in enumerate(bundle.entries):
                if entry.target is not None:
                    start = self.program.cells[self.assembly.layout.of(entry.target)]
                    self.program.cells[held + index] = start

    def _loop(
        self,
        end: int,
        sink: Sink | None,
        progress: Progress | None,
        drive: Drive | None,
        wish: Wish,
    ) -> None:
        kernel = self.program.kernel
        pauses = self._pauses
        stops = sorted(tick for tick in pauses if kernel.tick <= tick <= end)
        self._whereabouts.clear()
        foreign = [fmu for fmu in self._fmus.values() if not fmu.is_trusted]
        chunk = self._chunk
        told = began = time.perf_counter()
        try:
            if drive is not None:
                with self._guarding(*foreign):
                    stop = drive(
                        self.program, self._components, self.groups, sink, end=end, wish=wish
                    )
                self._raise_unless_done(stop)
                return
            while kernel.tick < end and not wish.is_made:
                if stops and kernel.tick == stops[0]:
                    pauses[stops.pop(0)]()
                first = kernel.tick
                stop = min(end, first + chunk, *stops[:1])
                before = time.perf_counter()
                with self._guarding(*foreign):
                    self._run_chunk(first, stop, sink)
                now = time.perf_counter()
                if now - before < CHUNK_SECONDS[0]:
                    chunk = min(2 * chunk, LONGEST_CHUNK)
                elif now - before > CHUNK_SECONDS[1]:
                    chunk = max(chunk // 2, 1)
                if progress is not None and (now - told > 0.1 or kernel.tick == end):
                    told = now
                    progress(kernel.tick, now - began)
            if stops and kernel.tick == stops[0]:
                pauses[stops.pop(0)]()
        finally:
            self._chunk = chunk
            self._wall_time = time.perf_counter() - began

    def _run_chunk(self, first: int, stop: int, sink: Sink | None) -> None:
        self.program.packets.draw()
        self.program.turning.turn_as_asked(first)
        if sink is not None:
            self._open_rows(first, stop, sink)
        try:
            while (outcome := self._advance(stop)) is Stop.CALL:
                self._serve()
            self._raise_unless_done(outcome)
        finally:
            if sink is not None:
                self._commit_rows(first, sink)

    def _advance(self, stop: int) -> Stop:
        return Stop(library().kernel_run(_address(self.program), stop))

    def _evaluate(self, program: int) -> Stop:
        return Stop(library().kernel_evaluate(_address(self.program), program))

    def _serve(self) -> None:
        operation = int(self.program.kernel.operation)
        call = self.program.calls[operation]
        if operation not in self._handlers:
            self._handlers[operation] = guarded(self.program, self._components, call)
        try:
            with sentences(call.component, f"in {call.method} at {moment(self.program)}"):
                self._handlers[operation](int(self.program.kernel.tick))
        except StatusReturnedError:
            self._raise_unless_done(Stop.STATUS)

    def _raise_unless_done(self, stop: Stop) -> None:
        if stop is not Stop.DONE:
            component = str(self.program.stopped_at().unit)
            if stop is Stop.STATUS and component in self._fmus:
                self._fmus[component].judge(int(self.program.kernel.status))
            error = explain(stop, self.program, self._fmus)
            if not isinstance(error, EndAsked):
                self._failed.add(component)
            with placed_refusal(self.scenario, component):
                raise error

    def _open_rows(self, first: int, stop: int, sink: Sink) -> None:
        for number, group in enumerate(self.groups):
            rows = -(-stop // group.period) - -(-first // group.period)
            record = self.program.records[number]
            record.row, record.row_count = 0, rows
            if rows:
                self._rows[number] = sink.buffer(number, rows)
                record.rows = self._rows[number].ctypes.data

    def _commit_rows(self, first: int, sink: Sink) -> None:
        for number, group in enumerate(self.groups):
            record = self.program.records[number]
            if record.row_count:
                sink.commit(number, -(-first // group.period) * group.period, record.row)


def _tell_nobody(component: str, what: str) -> None:
    del component, what


def _address(program: Program) -> int:
    return ctypes.addressof(program.kernel)
