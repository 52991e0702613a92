"""The control loop's process: no other thread, real-time just before the first tick, one ear.

FMUs, devices, link, pacer, and rows into shared memory. It beats every tick, and ends between two
ticks when anybody asks for it; its components then bring their devices to zero.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from typing import Any, Protocol

from cosim.base.errors import CohapticError, RunError
from cosim.base.system.grants import end_priority, prepare_loop
from cosim.base.system.pulse import FINISHED, RUNNING, Pulse
from cosim.base.system.supervised import Supervised
from cosim.master.run.obituary import COMPLETE
from cosim.master.run.simulation import Simulation
from cosim.realtime.deadlines import Deadlines
from cosim.realtime.live import STATUS_TICKS, Feed, StatusWriter
from cosim.realtime.messages import Begun, LoopReport, Message, Over, as_told
from cosim.realtime.paced_loop import paced
from cosim.realtime.pacing import Pacer
from cosim.realtime.relay import RelaySink
from cosim.realtime.ring import Ring
from cosim.realtime.shared.text_ring import TextRing
from cosim.realtime.signals import Ear
from cosim.realtime.usage import Usage


class LoopPacer(Pacer, Protocol):
    """What waits before each tick: the deadlines' pacer, or a station's around it."""

    @property
    def deadlines(self) -> Deadlines:
        """Lateness counted so far."""
        ...

    def summary(self) -> dict[str, Any]:
        """Deadlines and what the ticks' time went into."""
        ...


class ControlLoop:
    """Runs ``simulation`` in this process; ``tell`` sends a message to the command.

    Without ``real_time`` the system is asked for nothing. ``facts`` is asked after the loop.
    """

    def __init__(
        self,
        simulation: Simulation,
        pacer: LoopPacer,
        pulse: Pulse,
        tell: Callable[[Message], None],
        *,
        real_time: bool,
        cpu: int | None,
        facts: Callable[[], Mapping[str, Any]] | None,
    ) -> None:
        self._simulation, self._pacer, self._pulse, self._tell = simulation, pacer, pulse, tell
        self._real_time, self._cpu, self._facts = real_time, cpu, facts
        self._report = LoopReport()

    def run(
        self,
        rings: Sequence[Ring],
        texts: TextRing | None,
        feed: Feed,
        open_devices: Callable[[], Generator[Supervised]],
        devices: Callable[[], Sequence[Supervised]],
    ) -> int:
        """Open the devices that nobody else can, and run to the end; the exit status."""
        report = self._report
        Ear(self._pulse.ask_to_stop).listen()
        own: list[Supervised] = []
        try:
            own.extend(open_devices())
        except CohapticError as error:
            for device in own:
                device.close()
            report.error = as_told(error)
            self._tell(report)
            return error.exit_status
        present = devices()
        told = StatusWriter(feed.status, present, self._pacer.deadlines)
        watched = _Watched(self, told)
        status = 0
        try:
            report.outcome = self._simulation.run(
                RelaySink(rings, self._simulation.groups, texts),
                drive=paced(watched),
                keep_fmus=True,
            )
        except CohapticError as error:
            status = error.exit_status
            report.error = as_told(error)
            report.outcome = self._simulation.outcome
        except SystemExit as stop:
            status, report.left = 1, str(stop.code)
            report.outcome = self._simulation.outcome
        finally:
            self._pulse.state(FINISHED)
            if self._real_time:
                end_priority()
            told.write(watched.tick)
        report.deadlines = {**self._pacer.summary(), **watched.usage.summary()}
        report.latency = {device.name: device.latency_ticks for device in present}
        report.slow = [said for device in present if (said := device.slowness) is not None]
        report.texts = [] if texts is None else texts.rest()
        report.facts = self._facts() if self._facts is not None else None
        self._tell(report)
        before = self._simulation.outcome
        self._simulation.close()  # an FMU that dies of it finds everything told
        failed = bool(self._simulation.closing_error) and report.error is None
        if failed:
            status, report.error = 1, RunError(f"{self._simulation.closing_error}; {COMPLETE}")
        if failed or self._simulation.outcome is not before:
            report.outcome = self._simulation.outcome
            self._tell(report)
        self._tell(Over())
        return status

    def make_ready(self) -> None:
        """Lock memory and take priority, which takes a good part of a second."""
        if self._real_time:
            self._report.grants = prepare_loop(cpu=self._cpu)
            for grant in self._report.grants:
                self._tell(grant)

    def begin(self) -> None:
        """The first tick is due: from here on the supervisor watches the beats."""
        self._tell(Begun())
        self._pulse.beat()
        self._pulse.state(RUNNING)

    @property
    def pacer(self) -> LoopPacer:
        """What waits before each tick."""
        return self._pacer

    @property
    def pulse(self) -> Pulse:
        """The memory shared with supervisor and command."""
        return self._pulse


class _Watched:
    """The pacer with what the loop's process needs besides: beats, and an end when it is asked for.

    The process is made real-time just before the first tick, not earlier: setting up FMUs and
    devices takes longer than a real-time loop may run on end.
    """

    def __init__(self, loop: ControlLoop, status: StatusWriter) -> None:
        self._loop, self._status = loop, status
        self._pulse, self._beat, self._wait = loop.pulse, loop.pulse.beat, loop.pacer.wait
        self.tick = 0
        self.work = loop.pacer.work
        self.usage = Usage()

    def start(self, tick: int) -> None:
        """Make the process ready, wait for whom there is to wait for, and begin."""
        # Before others wait for this loop.
        self._loop.make_ready()
        self._loop.pacer.start(tick)
        self._loop.begin()
        self.usage.begin()

    def wait(self, tick: int) -> None:
        """Return when ``tick`` may run.

        Raises:
            KeyboardInterrupt: somebody has asked for the end.
        """
        if self._pulse.stop_asked:
            raise KeyboardInterrupt
        self._wait(tick)
        self._beat()
        self.tick = tick
        if tick % STATUS_TICKS == 0:
            self._status.write(tick)
