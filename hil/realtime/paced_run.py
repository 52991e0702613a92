"""A scenario in real time: recorder, supervisor and control loop in three processes.

The command's process assembles the scenario and records. It forks the supervisor, which opens the
devices (and asks people what has to be asked) and forks the loop. The loop's process has no other
thread: FMUs, devices, link, pacer, and rows into shared memory.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import signal
import time
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any, Protocol

from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.pulse import FINISHED, RUNNING, Pulse
from hil.device.component import DeviceComponent
from hil.device.contract import ZERO
from hil.device.device import Device
from hil.realtime import session as sessions
from hil.realtime.live import STATUS_TICKS, Feed, StatusWriter
from hil.realtime.relay import RelayPump, RelaySink, make_rings
from hil.realtime.ring import Ring
from hil.realtime.session import Session
from hil.realtime.supervisor import STALL_SECONDS, Ending, supervise
from hil.realtime.system import Grant, prepare_loop
from hil.realtime.usage import Usage

PUMP_SECONDS = 0.02
LOCKSTEP_STALL_SECONDS = 10.0
"""With devices in lock-step alone, time is counted in exchanges and the clock stops nothing."""


class LoopPacer(Protocol):
    """What waits before each tick: the master's pacer, or a station's around it."""

    @property
    def work(self) -> Any:
        """Where the loop notes how long the parts of a tick took."""
        ...

    def start(self, tick: int) -> None:
        """The loop is about to run ``tick``; returns when that is near."""
        ...

    def wait(self, tick: int) -> None:
        """Return when ``tick`` may run."""
        ...

    @property
    def deadlines(self) -> Any:
        """Lateness counted so far."""
        ...

    def summary(self) -> dict[str, Any]:
        """Deadlines and what the ticks' time went into."""
        ...


@dataclass(slots=True)
class LoopReport:
    """What the loop's process says before it ends."""

    outcome: Any = None
    error: tuple[int, str] | None = None
    """Exit status and sentence of what ended it."""
    deadlines: dict[str, Any] = field(default_factory=dict[str, Any])
    grants: list[Grant] = field(default_factory=list[Grant])
    facts: Mapping[str, Any] | None = None


@dataclass(slots=True)
class PacedRun:
    """Runs a simulation of the master in real time; afterwards it knows how that went.

    ``simulation`` is ``cosim.master``'s, handed in by the command, as are recorder and progress.
    Without ``real_time`` the system is asked for nothing.
    """

    session: Session
    pacer: LoopPacer | None = None
    facts: Callable[[], Mapping[str, Any]] | None = None
    """Asked in the loop's process after the loop; what it says is in ``report``."""
    cpu: int | None = None
    real_time: bool = True
    say: Callable[[str], None] = print
    console: Callable[[Feed], None] | None = None
    """Called some fifty times a second in the recording process, to show how things stand."""
    report: LoopReport | None = None
    ending: Ending | None = None
    _sentences: list[str] = field(default_factory=list[str])
    _reached: int = 0
    """Ticks whose rows have come."""

    def __call__(self, simulation: Any, recorder: Any, progress: Any) -> None:
        """Run to the scenario's end.

        Raises:
            InputError: a component or a device cannot be used.
            RunError: the loop failed, a device faulted, or it is not known to be at zero.
        """
        if not hasattr(os, "fork"):
            raise InputError("real time needs Linux or macOS: this system cannot fork the loop")
        rate: Fraction = simulation.scenario.base_rate
        rings = make_rings(simulation.groups, rate)
        feed = _feed(simulation, float(rate), rings)
        said, tell = os.pipe()
        try:
            supervisor = os.fork()
            if supervisor == 0:
                os.close(said)
                _supervisor_process(self, _Work(simulation, rings, rate, tell, feed))
            os.close(tell)
            with _ending_with_the_loop(supervisor):
                self._record(_Work(simulation, rings, rate, said, feed), recorder, progress)
        finally:
            os.close(said)
            feed.remove()
            for ring in rings:
                ring.remove()
        self._conclude(simulation)

    def statistics(self) -> dict[str, Any]:
        """Deadlines and what the system granted, for the manifest."""
        if self.report is None:
            return {}
        grants = {grant.name: grant.sentence for grant in self.report.grants}
        return {**self.report.deadlines, "system": grants}

    def found(self) -> Mapping[str, Any]:
        """What ``facts`` said in the loop's process."""
        facts = self.report.facts if self.report is not None else None
        return facts or {}

    def idle(self) -> bool:
        """In the loop's process before the first tick: keep every device at zero; any there?"""
        for device in self.session.devices:
            device.read(-1)
            device.write(-1, ZERO)
            device.raise_fault()
        return bool(self.session.devices)

    def _record(self, work: _Work, recorder: Any, progress: Any) -> None:
        """Pump rows until the supervisor hangs up."""
        began = time.perf_counter()
        pump: RelayPump | None = None
        messages = b""
        open_ = True
        while open_:
            ready, _, _ = select.select([work.pipe], [], [], PUMP_SECONDS)
            if ready:
                part = os.read(work.pipe, 65536)
                messages, open_ = messages + part, bool(part)
            *whole, messages = _split(messages)
            for message in whole:
                pump = self._take(message, work, recorder) or pump
            if self.console is not None:
                self.console(work.feed)
            if pump is not None:
                self._reached = min(pump.pump(), work.simulation.scenario.ticks)
                if progress is not None:
                    progress(self._reached, time.perf_counter() - began)

    def _take(self, message: Any, work: _Work, recorder: Any) -> RelayPump | None:
        if message == "begun":
            groups = work.simulation.groups
            recorder.begin(groups, work.rate)
            work.feed.publish(groups, getattr(recorder, "folder", None))
            return RelayPump(work.rings, groups, recorder)
        if isinstance(message, Grant):
            if not message.granted:
                self.say(message.sentence)
        elif isinstance(message, LoopReport):
            self.report = message
        elif isinstance(message, Ending):
            self.ending = message
        elif isinstance(message, list):
            self._sentences += message
        return None

    def _conclude(self, simulation: Any) -> None:
        if self.report is not None and self.report.outcome is not None:
            simulation.outcome = self.report.outcome
        else:
            simulation.outcome = replace(simulation.outcome, ticks=self._reached)
        error = self.report.error if self.report is not None else None
        if error is not None:
            text = ". ".join([error[1], *self._sentences])
            raise InputError(text) if error[0] == 2 else RunError(text)
        if self._sentences:
            raise RunError(". ".join(self._sentences))


@dataclass(frozen=True, slots=True)
class _Work:
    """What the processes of one run share."""

    simulation: Any
    rings: list[Ring]
    rate: Fraction
    pipe: int
    feed: Feed


def _supervisor_process(run: PacedRun, work: _Work) -> None:
    """Open the devices, supervise the loop, report; never returns."""
    devices: list[Device] = []
    out_of_reach = [name for name, component in _devices(work) if not component.kind.shares_port]
    try:
        pulse = Pulse()
        session = sessions.begin(run.session)
        session.pulse, session.clock = pulse, time.monotonic
        devices.extend(_opening(work, session, shared=True))
        timed = out_of_reach or any(not device.lockstep for device in devices)
        ending = supervise(
            devices,
            lambda: _loop(run, work, pulse),
            pulse,
            stall=STALL_SECONDS if timed else LOCKSTEP_STALL_SECONDS,
            real_time=run.real_time,
        )
        _say(work.pipe, ending)
        sentences = ending.sentences(devices)
        if ending.status in {0, 1, 2}:
            sentences = sentences[1:] if ending.reason else sentences
        else:
            sentences += [
                f"{name} is out of the supervisor's reach; its board's watchdog drops the torque"
                for name in out_of_reach
            ]
        _say(work.pipe, sentences)
    except CohapticError as error:
        _say(work.pipe, LoopReport(error=(error.exit_status, str(error))))
    except BaseException as error:
        _say(
            work.pipe,
            LoopReport(error=(1, f"the supervisor failed: {type(error).__name__}: {error}")),
        )
    finally:
        for device in devices:
            with contextlib.suppress(Exception):
                device.close()
        os._exit(0)


def _devices(work: _Work) -> list[tuple[str, DeviceComponent]]:
    parts = work.simulation.assembly.participants.items()
    found = [(name, part.component) for name, part in parts]
    return [(name, each) for name, each in found if isinstance(each, DeviceComponent)]


def _opening(work: _Work, session: Session, *, shared: bool) -> Generator[Device]:
    """Open the devices that a supervisor can hand on, or in the loop's process the others.

    One by one, so that the caller knows of those that are open when the next one fails.
    """
    for name, component in _devices(work):
        if component.kind.shares_port is shared:
            control = work.simulation.assembly.participants[name].period / work.rate
            written = work.simulation.scenario.components[name].parameters
            session.number = len(session.ready)
            session.ready[name] = component.open(control, session, dict(written))
            yield session.ready[name]


def _loop(run: PacedRun, work: _Work, pulse: Pulse) -> int:
    """The control loop's process."""
    assert run.pacer is not None
    # A reader that is gone shows as an error, not as a death.
    signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    report = LoopReport()
    own: list[Device] = []
    try:
        own.extend(_opening(work, run.session, shared=False))
    except CohapticError as error:
        for device in own:
            device.close()
        report.error = (error.exit_status, str(error))
        _say(work.pipe, report)
        return error.exit_status
    told = StatusWriter(
        work.feed.status,
        [run.session.ready[name] for name in work.feed.devices],
        run.pacer.deadlines,
    )
    pacer = _Watched(run, report, pulse, lambda message: _say(work.pipe, message), told)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, pacer.note)
    status = 0
    try:
        report.outcome = work.simulation.run(RelaySink(work.rings), pacer=pacer)
    except CohapticError as error:
        status = error.exit_status
        report.error = (status, str(error))
        report.outcome = work.simulation.outcome
    finally:
        pulse.state(FINISHED)
        told.write(pacer.tick)
    report.deadlines = {**run.pacer.summary(), **pacer.usage.summary()}
    report.facts = run.facts() if run.facts is not None else None
    _say(work.pipe, report)
    return status


class _Watched:
    """The pacer with what the loop's process needs besides: a heartbeat, an ear for signals.

    The process is made real-time just before the first tick, not earlier: setting up FMUs and
    devices takes longer than a real-time loop may run on end.
    """

    def __init__(
        self,
        run: PacedRun,
        report: LoopReport,
        pulse: Pulse,
        tell: Callable[[Any], None],
        status: StatusWriter,
    ) -> None:
        assert run.pacer is not None
        self._run, self._report, self._tell = run, report, tell
        self._pulse, self._beat, self._wait = pulse, pulse.beat, run.pacer.wait
        self._status = status
        self._stop = False
        self.tick = 0
        self.work = run.pacer.work
        self.usage = Usage()

    def note(self, *_: object) -> None:
        """Take a signal: the run ends between two ticks."""
        self._stop = True

    def start(self, tick: int) -> None:
        run = self._run
        assert run.pacer is not None
        if run.real_time:
            # Locking memory takes a good part of a second: before others wait for this loop.
            self._report.grants = prepare_loop(cpu=run.cpu)
            for grant in self._report.grants:
                self._tell(grant)
        run.pacer.start(tick)
        self._tell("begun")
        self.usage.begin()
        self._beat()
        self._pulse.state(RUNNING)

    def wait(self, tick: int) -> None:
        if self._stop:
            raise KeyboardInterrupt
        self._wait(tick)
        self._beat()
        self.tick = tick
        if tick % STATUS_TICKS == 0:
            self._status.write(tick)


def _feed(simulation: Any, rate: float, rings: list[Ring]) -> Feed:
    """What others may watch of a run."""
    devices = {
        name: participant.component.file.linkage
        for name, participant in simulation.assembly.participants.items()
        if isinstance(participant.component, DeviceComponent)
    }
    return Feed(simulation.scenario.name, rate, devices, rings)


@contextlib.contextmanager
def _ending_with_the_loop(supervisor: int) -> Generator[None]:
    """Leave only when the supervisor has ended; whatever else ends this run ends it, too.

    Signals to stop are handed on (from a terminal, Ctrl-C reaches the loop by itself as well): the
    run ends at its next tick.
    """

    def hand_on(number: int, _: object) -> None:
        with contextlib.suppress(ProcessLookupError):
            os.kill(supervisor, number)

    before = {
        signal.SIGINT: signal.signal(signal.SIGINT, hand_on),
        signal.SIGTERM: signal.signal(signal.SIGTERM, hand_on),
    }
    try:
        yield
    except BaseException:
        hand_on(signal.SIGTERM, None)
        raise
    finally:
        os.waitpid(supervisor, 0)
        for number, handler in before.items():
            signal.signal(number, handler)


def _say(pipe: int, message: Any) -> None:
    data = pickle.dumps(message)
    frame = len(data).to_bytes(8, "little") + data
    with contextlib.suppress(BrokenPipeError):
        while frame:
            frame = frame[os.write(pipe, frame) :]


def _split(data: bytes) -> list[Any]:
    """Whole messages, then the bytes that are left."""
    found: list[Any] = []
    while len(data) >= 8 and len(data) >= 8 + (size := int.from_bytes(data[:8], "little")):
        found.append(pickle.loads(data[8 : 8 + size]))
        data = data[8 + size :]
    return [*found, data]
