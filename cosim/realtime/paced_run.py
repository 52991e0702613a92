"""A scenario in real time: command, supervisor and control loop in three processes.

The command's process assembles the scenario, opens the devices, asks people what has to be asked,
and records. It forks the supervisor, which forks the loop; each has a session of its own.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, NoReturn

from cosim.base.errors import InputError, RunError
from cosim.base.recording import Sink
from cosim.base.system.grants import LONGEST_BURST, Grant
from cosim.base.system.pulse import Pulse
from cosim.base.system.room import shared_folder
from cosim.base.system.supervised import Supervised
from cosim.master.run.execution.loop import Progress
from cosim.master.run.obituary import COMPLETE, KEPT, NOTHING, obituary
from cosim.master.run.simulation import Simulation
from cosim.realtime.command import Watch, zero_the_rest
from cosim.realtime.control_loop import ControlLoop, LoopPacer
from cosim.realtime.devices_of_run import DevicesOfRun
from cosim.realtime.live import Feed
from cosim.realtime.messages import Begun, Ending, LoopReport, Message, Over, say
from cosim.realtime.relay import RelayPump, make_rings, make_text_ring
from cosim.realtime.ring import Ring
from cosim.realtime.shared.leftovers import remove_leftovers
from cosim.realtime.signals import Ear, blocked, heard_by
from cosim.realtime.supervisor import STALL_SECONDS, supervise

LOCKSTEP_STALL_SECONDS = 10.0
"""With devices in lock-step alone, time is counted in exchanges and the clock stops nothing."""


@dataclass(slots=True)
class PacedRun:
    """Runs a simulation of the master in real time; afterwards it knows how that went.

    Without ``real_time`` the system is asked for nothing.
    """

    pacer: LoopPacer | None = None
    facts: Callable[[], Mapping[str, Any]] | None = None
    """Asked in the loop's process after the loop; what it says is in ``report``."""
    cpu: int | None = None
    real_time: bool = True
    say: Callable[[str], None] = print
    console: Callable[[Feed], None] | None = None
    """Called some fifty times a second in the recording process, to show how things stand."""
    about: Callable[[Simulation], Mapping[str, Any]] | None = None
    """What others who watch are told besides, such as the scene."""
    report: LoopReport | None = None
    ending: Ending | None = None
    pulse: Pulse = field(default_factory=Pulse)
    lost_rows: int = 0
    """Rows that came too fast for the recorder."""
    lost_texts: int = 0
    """Changes of texts that did."""
    _devices: DevicesOfRun | None = None
    _reached: int = 0
    """Ticks whose rows have come."""
    _has_begun: bool = False
    """Whether the first tick was due: from there on there is a record."""
    _granted: set[str] = field(default_factory=set[str])
    _is_over: bool = False
    """Whether the loop has closed its components and then ended by itself."""

    def __call__(self, simulation: Simulation, recorder: Sink, progress: Progress | None) -> None:
        """Run to the scenario's end.

        Raises:
            InputError: a component or a device cannot be used.
            RunError: the loop failed, a device faulted, or it is not known to be at zero.
        """
        if not hasattr(os, "fork"):
            raise InputError("real time needs Linux or macOS: this system cannot fork the loop")
        simulation.whereabouts.is_watched = True  # the loop's process, by its supervisor
        remove_leftovers(shared_folder())
        with ExitStack() as stack:
            run = _Run(self, simulation, stack)
            devices = self._devices = run.devices
            try:
                devices.open_shared()
            except BaseException:
                devices.close_all()  # nothing was forked yet: they are ours to zero
                raise
            devices.ask_for_the_rest()
            killed = run.record(recorder, progress)
        self._conclude(simulation, killed, devices.unsure())

    def statistics(self) -> dict[str, Any]:
        """Deadlines and what the system granted, for the manifest."""
        if self.report is None:
            return {}
        grants = {grant.name: grant.sentence for grant in self.report.grants}
        return {
            **self.report.deadlines,
            "system": grants,
            "lost_rows": self.lost_rows,
            "lost_texts": self.lost_texts,
            "slow_devices": self.report.slow,
            "latency_ticks": self.report.latency,
        }

    def found(self) -> Mapping[str, Any]:
        """What ``facts`` said in the loop's process."""
        facts = self.report.facts if self.report is not None else None
        return facts or {}

    def idle(self) -> bool:
        """In the loop's process before the first tick: keep every device at zero; any there?

        Raises:
            KeyboardInterrupt: somebody has asked for the end.
            RunError: a device is in fault.
        """
        if self.pulse.stop_asked:
            raise KeyboardInterrupt
        for device in self.devices.values():
            device.idle()
        return bool(self.devices)

    @property
    def devices(self) -> Mapping[str, Supervised]:
        """Those that are open in this process, by component."""
        return {} if self._devices is None else self._devices.open

    def take(self, message: Message) -> None:
        """Something that supervisor or loop have said."""
        if isinstance(message, Grant):
            if message.granted:
                self._granted.add(message.name)
            else:
                self.say(message.sentence)
        elif isinstance(message, LoopReport):
            self.report = message
        elif isinstance(message, Begun):
            self._has_begun = True
        elif isinstance(message, Over):
            self._is_over = True
        else:
            self.ending = message

    def reach(self, tick: int) -> int:
        """The rows before ``tick`` have come."""
        self._reached = tick
        return tick

    def _conclude(self, simulation: Simulation, killed: str | None, unsure: list[str]) -> None:
        report = self.report
        if report is not None and report.outcome is not None:
            simulation.outcome = report.outcome
        else:
            said = simulation.whereabouts.said(simulation.scenario)
            simulation.outcome = replace(simulation.outcome, ticks=self._reached, said=said)
        error = report.error if report is not None else None
        sentences = [str(error)] if error is not None else self._ended(simulation, killed)
        for sentence in report.slow if report is not None else ():
            self.say(sentence)
        if self.lost_rows:
            self.say(f"the recorder was too slow for {self.lost_rows} rows: they are held values")
        if self.lost_texts:
            self.say(
                f"the recorder was too slow for {self.lost_texts} changes of texts: others "
                "followed them at once"
            )
        if not sentences and not unsure:
            return
        if isinstance(error, InputError) and not unsure:
            raise error
        raise RunError(". ".join([*sentences, *unsure]))

    def _ended(self, simulation: Simulation, killed: str | None) -> list[str]:
        """What has to be said of processes that ended; nothing where the loop came to its end."""
        if killed is not None:
            return [killed]
        ending = self.ending
        if ending is None:
            return ["supervisor and control loop died"]
        if ending.killed:
            component, doing = simulation.whereabouts.sentence(simulation.scenario)
            return (
                [f"{ending.reason} while {component} was at work {doing}"]
                if component
                else [ending.reason]
            )
        left = self.report.left if self.report is not None else None
        if self._is_over and left is None:
            return [ending.reason] if ending.reason else []
        burst = LONGEST_BURST if {"burst", "priority"} <= self._granted else None
        whereabouts, scenario = simulation.whereabouts, simulation.scenario
        sentence = obituary(ending.status, whereabouts, scenario, left, burst=burst)
        is_whole = self.report is not None and left is None
        kept = COMPLETE if is_whole else KEPT if self._has_begun else NOTHING
        return [f"{sentence}; {kept}"]


class _Run:
    """One run's rings and processes; ``stack`` gives back what it takes."""

    def __init__(self, paced: PacedRun, simulation: Simulation, stack: ExitStack) -> None:
        self._paced, self._simulation = paced, simulation
        self._pulse: Pulse = paced.pulse
        self._rate: Fraction = simulation.scenario.base_rate
        self.devices = DevicesOfRun(simulation, paced.pulse)
        stack.callback(self.devices.let_go)
        self.rings: list[Ring] = make_rings(simulation.groups, self._rate)
        for ring in self.rings:
            stack.callback(ring.remove)
        self.texts = make_text_ring(simulation.groups)
        if self.texts is not None:
            stack.callback(self.texts.remove)
        self._more = paced.about(simulation) if paced.about is not None else None
        self.feed = Feed(
            simulation.scenario.name,
            float(self._rate),
            self.devices.parts,
            self.rings,
            start=float(simulation.scenario.start_time),
        )
        stack.callback(self.feed.remove)

    def record(self, recorder: Sink, progress: Progress | None) -> str | None:
        """Fork, and record until nobody can write any more; why they were killed, if they were."""
        said, tell = os.pipe()
        alive, hold = os.pipe()
        with blocked():
            supervisor = os.fork()
            if supervisor == 0:
                for mine in (said, hold):
                    os.close(mine)
                self._supervisor_process(tell, alive)
            for theirs in (tell, alive):
                os.close(theirs)
            ear = Ear(self._pulse.ask_to_stop)
            try:
                with heard_by(ear) as wake:
                    return self._record(supervisor, said, wake, recorder, progress)
            finally:
                os.close(said)
                os.close(hold)

    def _record(
        self,
        supervisor: int,
        pipe: int,
        wake: int,
        recorder: Sink,
        progress: Progress | None,
    ) -> str | None:
        paced, began = self._paced, time.perf_counter()
        pumps: list[RelayPump] = []

        def take(message: Message) -> None:
            if isinstance(message, Begun):
                groups = self._simulation.groups
                recorder.begin(groups, self._rate)
                self.feed.publish(groups, getattr(recorder, "folder", None), self._more)
                pumps.append(RelayPump(self.rings, groups, recorder, self.texts))
            paced.take(message)

        def now_and_then() -> None:
            if paced.console is not None:
                paced.console(self.feed)
            for pump in pumps:
                reached = paced.reach(min(pump.pump(), self._simulation.scenario.ticks))
                paced.lost_rows = pump.lost
                paced.lost_texts = pump.skipped
                if progress is not None:
                    progress(reached, time.perf_counter() - began)

        devices = self.devices
        watch = Watch(
            supervisor, self._pulse, pipe, wake, len(devices.parts), timed=devices.are_timed
        )
        failed: BaseException | None = None
        try:
            watch.to_the_end(take, now_and_then)
        except BaseException as error:  # a full disk, a console that is gone: the run has to end
            failed = error
            self._pulse.ask_to_stop()
            watch.to_the_end(paced.take, lambda: None)
        zero_the_rest(devices.numbered(), self._pulse)
        os.waitpid(supervisor, 0)
        watch.close()
        if failed is not None:
            raise failed
        now_and_then()
        for change in paced.report.texts if pumps and paced.report is not None else ():
            recorder.put_text(*change)
        return watch.killed

    def _supervisor_process(self, tell: int, alive: int) -> NoReturn:
        """Supervise the loop, report; never returns."""
        try:
            os.setsid()
            ending = supervise(
                self.devices.numbered(),
                lambda: self._loop(tell),
                self._pulse,
                command=alive,
                stall=STALL_SECONDS if self.devices.are_timed else LOCKSTEP_STALL_SECONDS,
                real_time=self._paced.real_time,
            )
            say(tell, ending)
        except BaseException as error:
            text = f"the supervisor failed: {type(error).__name__}: {error}"
            say(tell, LoopReport(error=RunError(text)))
        finally:
            os._exit(0)

    def _loop(self, tell: int) -> int:
        """In the loop's process."""
        paced = self._paced
        assert paced.pacer is not None, "a paced run has a pacer"
        loop = ControlLoop(
            self._simulation,
            paced.pacer,
            self._pulse,
            lambda message: say(tell, message),
            real_time=paced.real_time,
            cpu=paced.cpu,
            facts=paced.facts,
        )
        return loop.run(
            self.rings,
            self.texts,
            self.feed,
            lambda: self.devices.opening(shared=False),
            self.devices.in_order,
        )
