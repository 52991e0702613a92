"""A run: components started, ticks run in chunks by the kernel, rows handed over, all closed."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import replace
from types import TracebackType
from typing import Any

from cosim.base.component import Component
from cosim.base.errors import EndAsked, InputError, RunError
from cosim.base.recording import RecordGroup, Sink
from cosim.base.system.garbage import without_collecting
from cosim.master.assembly.assemble import Assembly, Only, put_together
from cosim.master.components.participant import Factory
from cosim.master.fmu.instance import Fmu
from cosim.master.kernel.program import Program
from cosim.master.run import by_hand, checkpoint
from cosim.master.run.execution.branching import Branching
from cosim.master.run.execution.fmus import Told
from cosim.master.run.execution.life_cycle import LifeCycle
from cosim.master.run.execution.loop import ChunkedLoop, Drive, Pause, Progress
from cosim.master.run.execution.restoring import go_on, put_back
from cosim.master.run.interrupt import wish_to_stop
from cosim.master.run.outcome import Outcome
from cosim.master.run.replay import with_events
from cosim.master.run.snapshot import Snapshot
from cosim.master.run.whereabouts import Whereabouts
from cosim.scenario import Kind, Scenario


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
    """One run of a scenario; a context manager that closes every component on every exit path.

    FMUs run in this process, unless their component says ``isolate: process``. What one of somebody
    else changes of it (working directory, locale, floating point mode, signal handlers) is put back
    after each call of a method, and one that calls ``exit`` ends it with a sentence and status 1. A
    crash, ``abort`` and ``_exit`` end it without a word: the commands run simulations in a child.
    """

    def __init__(self, assembly: Assembly, whereabouts: Whereabouts | None = None) -> None:
        self._whereabouts = whereabouts or Whereabouts()
        self._whereabouts.is_watched = whereabouts is not None
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
        self._cycle = LifeCycle(assembly, self.program, self._whereabouts)
        self._loop = ChunkedLoop()
        self._restored: Snapshot | None = None
        self._branching = Branching(self._cycle)
        self._end = 0

    @property
    def assembly(self) -> Assembly:
        """What the scenario was made into; another one after ``renew`` and ``branch``."""
        return self._cycle.assembly

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
    def notes(self) -> tuple[str, ...]:
        """What is worth telling: unit conversions."""
        return self.assembly.notes

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
        briefly: bool = False,
    ) -> Outcome:
        """Run to tick ``until`` (the scenario's end unless given), from ``restore``'s tick or 0.

        Ctrl-C ends the run early; what was reached has been handed to ``sink`` in any case.
        ``drive`` runs the program in place of the loop (``cosim.realtime``) and tells nobody how
        far it is; the numbers are the same. ``pauses`` are called between two ticks, before
        anything of the tick is done by which they are kept; not with ``drive``.
        Every component is closed at the end; with ``keep_fmus`` the FMUs only by ``close`` or
        ``finish``, so that one which dies of it finds the record finished. With ``mark_at_end``
        nothing is closed, and later runs begin where this one ended (``branch``). ``briefly``: the
        outcome only says how far the run came, for somebody who asks for neither packets nor
        warnings.

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: an FMU returned an error status, put out NaN, or a component failed; or an FMU
                failed when it was closed.
        """
        end = self.scenario.ticks if until is None else until
        interrupted, ended_by = False, ""
        try:
            if not self._branching.has_begun:
                last = self.scenario.ticks if mark_at_end else end
                self._start(last, recorded=sink is not None)
            self.program.texts.record_into(sink)
            if sink is not None:
                sink.begin(self.groups, self.scenario.base_rate)
            self._whereabouts.clear()
            with wish_to_stop(self._whereabouts.hear) as wish:
                if drive is not None:
                    self._loop.drive(drive, self._cycle.kernel_run, end, sink, wish)
                else:
                    run, stops = self._cycle.kernel_run, pauses or {}
                    self._loop.run(run, end, sink, wish, pauses=stops, progress=progress)
            interrupted = wish.is_made and self.program.kernel.tick < end
            if mark_at_end and not interrupted:
                self._branching.mark()
        except KeyboardInterrupt:
            interrupted = True
        except EndAsked as end_asked:
            ended_by = str(end_asked)
        finally:
            self.outcome = self._cycle.reached(
                self._loop.wall_time, interrupted=interrupted, ended_by=ended_by, briefly=briefly
            )
            if not self._branching.has_begun:
                self._cycle.close_components()
                if not keep_fmus:
                    self.close()
        if not keep_fmus and self.closing_error:
            raise RunError(self.closing_error)
        return self.outcome

    def finish(self) -> str:
        """Terminate and free the FMUs that are not ours, after a run with ``keep_fmus``.

        Another run has them anew in any case; what they fail in belongs to the one that is over.
        The sentence of one that failed or whose process ended, or nothing. Runs that ``branch``
        share their FMUs, so that nothing is done between them.
        """
        return "" if self._branching.has_begun else self._cycle.fmus.finish()

    def branch(self, assembly: Assembly) -> None:
        """Make ready for a run that begins where the one with ``mark_at_end`` ended.

        What channels do from then on is that of ``assembly``: one that ``with_values`` made.

        Raises:
            InputError: there is no such place, or components have other values.
            RunError: a component does not take its state back.
        """
        self._branching.go_back(assembly)

    def renew(self, assembly: Assembly) -> None:
        """Make ready for another run, after one with ``keep_fmus``; nothing of that one is left.

        ``assembly`` is the one that this simulation was made of, or one that ``with_values`` made
        of it: the program stays as it is.

        Raises:
            InputError: it is of another plan.
            RunError: an FMU was lost for good, or failed when it was closed (see ``finish``).
        """
        self._cycle.fmus.refuse_lost()
        if assembly.plan is not self.assembly.plan or assembly.layout is not self.assembly.layout:
            raise InputError("A simulation can only be renewed with an assembly of the same plan.")
        if sentence := self.finish():
            raise RunError(sentence)
        self._restored = None
        self._cycle.rewind(assembly)

    def start(self, until: int | None = None, *, recorded: bool = False) -> None:
        """Start every component; then ``advance``, ``snapshot`` and ``restore`` as often as wanted.

        For those that go on from one state many times. ``until`` is the last tick (the scenario's
        end unless given); ``recorded`` says whether ``advance`` will be given a sink.

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: it failed.
        """
        self._start(self.scenario.ticks if until is None else until, recorded=recorded)

    def advance(self, tick: int, sink: Sink | None = None) -> None:
        """Run on to a tick, after ``start``; ``sink`` has begun.

        In this process, as all of this class.

        Raises:
            EndAsked: a model has come to its end, which is a good one.
            RunError: an FMU returned an error status, put out NaN, or a component failed.
        """
        self._cycle.kernel_run.run_to(tick, sink)

    def set(self, values: Mapping[str, Any]) -> None:
        """Turn knobs of the scenario from the next tick on; all of them, or none.

        Keys and values are those of an event: ``{"coupler.stiffness": "400 N/m", "lan.delay": 2}``.
        May be called from any thread. ``replay`` has what was turned, and when.

        Raises:
            InputError: there is no such knob, a connection drives it, or it does not go so far.
        """
        by_hand.turn(self.assembly, self.program, values)

    def replay(self) -> Scenario:
        """The scenario with everything that ``set`` turned as events: it gives the same run."""
        return with_events(self.scenario, self.assembly.knobs, self.program.turning.by_hand)

    def snapshot(self) -> Snapshot:
        """The state between two ticks: after ``start``, or in one of ``run``'s pauses.

        Raises:
            InputError: a device, or a component without ``save`` and ``load``.
            RunError: a component failed; or nothing runs.
        """
        if not self._cycle.is_running:
            raise RunError("Nothing runs of which a snapshot could be taken.")
        with self._cycle.guarding():
            return checkpoint.take(*self._cycle.state)

    def restore(self, snapshot: Snapshot) -> None:
        """Go on from a snapshot: at once where the run has started, else when it starts.

        An FMU that does not give its state away is run again from tick 0 when the run starts, and
        all values must then be those of the snapshot.

        Raises:
            InputError: it is of another plan, of other components, or beyond the run's end.
            RunError: a component does not take its state back.
        """
        checkpoint.check(self.assembly, snapshot)
        if not self._cycle.is_running:
            self._restored = snapshot
            return
        put_back(self._cycle.kernel_run, snapshot, end=self._end)

    @property
    def fmus(self) -> Mapping[str, Fmu]:
        """The FMUs that run, by component; empty before the start."""
        return self._cycle.fmus.all

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
        self._cycle.close()
        if said := self._cycle.fmus.said():
            self.outcome = replace(self.outcome, said=said)

    @property
    def closing_error(self) -> str:
        """The sentence of an FMU that failed, or whose process ended, when it was closed."""
        return self._cycle.fmus.closing_error

    def __enter__(self) -> Simulation:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
        if kind is None and self.closing_error:
            raise RunError(self.closing_error)

    def _start(self, end: int, *, recorded: bool, rehearsal: Told | None = None) -> None:
        told: Told = rehearsal or (lambda _who, _what: None)
        # What is started again builds nothing.
        with nullcontext() if self._cycle.has_started else without_collecting():
            self._cycle.start(end, told, recorded=recorded, rehearsal=rehearsal is not None)
        self._end = end
        if self._restored is not None:
            go_on(self._cycle.kernel_run, self._restored, end=end, recorded=recorded)
