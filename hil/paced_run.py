"""A scenario in real time: recorder, supervisor and control loop in three processes.

The command's process assembles the scenario and records. It forks the supervisor, which opens the
devices (and asks people what has to be asked) and forks the loop. The loop's process has no other
thread: FMUs, devices, pacer, and rows into shared memory.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import select
import signal
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from cosim.errors import CohapticError, InputError, RunError
from hil import session as sessions
from hil.component import DeviceComponent
from hil.deadlines import Deadlines
from hil.device import Device
from hil.pulse import FINISHED, Pulse
from hil.realtime import Grant, Policy, RealtimePacer, prepare_loop
from hil.relay import RelayPump, RelaySink, make_rings
from hil.ring import Ring
from hil.session import Session
from hil.supervisor import Ending, supervise

PUMP_SECONDS = 0.02


@dataclass(slots=True)
class LoopReport:
    """What the loop's process says before it ends."""

    outcome: Any = None
    error: tuple[int, str] | None = None
    """Exit status and sentence of what ended it."""
    deadlines: dict[str, Any] = field(default_factory=dict[str, Any])
    grants: list[Grant] = field(default_factory=list[Grant])


@dataclass(slots=True)
class PacedRun:
    """Runs a simulation of the master in real time; afterwards it knows how that went.

    ``simulation`` is ``cosim.master``'s, handed in by the command, as are recorder and progress.
    """

    session: Session
    policy: Policy = "count"
    cpu: int | None = None
    say: Callable[[str], None] = print
    report: LoopReport | None = None
    ending: Ending | None = None
    _sentences: list[str] = field(default_factory=list[str])

    def __call__(self, simulation: Any, recorder: Any, progress: Any) -> None:
        """Run to the scenario's end.

        Raises:
            InputError: a component or a device cannot be used.
            RunError: the loop failed, a device faulted, or it is not known to be at zero.
        """
        rate: Fraction = simulation.scenario.base_rate
        rings = make_rings(simulation.groups, rate)
        said, tell = os.pipe()
        try:
            supervisor = os.fork()
            if supervisor == 0:
                os.close(said)
                _supervisor_process(self, _Work(simulation, rings, rate, tell))
            os.close(tell)
            with _ignoring_interrupts():
                self._record(_Work(simulation, rings, rate, said), recorder, progress)
                os.waitpid(supervisor, 0)
        finally:
            os.close(said)
            for ring in rings:
                ring.remove()
        self._conclude(simulation)

    def statistics(self) -> dict[str, Any]:
        """Deadlines and what the system granted, for the manifest."""
        if self.report is None:
            return {}
        grants = {grant.name: grant.sentence for grant in self.report.grants}
        return {**self.report.deadlines, "policy": self.policy, "system": grants}

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
            if pump is not None:
                tick = pump.pump()
                if progress is not None:
                    progress(min(tick, work.simulation.scenario.ticks), time.perf_counter() - began)

    def _take(self, message: Any, work: _Work, recorder: Any) -> RelayPump | None:
        if message == "begun":
            groups = work.simulation.groups
            recorder.begin(groups, work.rate)
            return RelayPump(work.rings, groups, recorder)
        if isinstance(message, LoopReport):
            self.report = message
            for grant in message.grants:
                if not grant.granted:
                    self.say(grant.sentence)
        elif isinstance(message, Ending):
            self.ending = message
        elif isinstance(message, list):
            self._sentences += message
        return None

    def _conclude(self, simulation: Any) -> None:
        if self.report is not None and self.report.outcome is not None:
            simulation.outcome = self.report.outcome
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


def _supervisor_process(run: PacedRun, work: _Work) -> None:
    """Open the devices, supervise the loop, report; never returns."""
    devices: list[Device] = []
    try:
        pulse = Pulse()
        session = sessions.begin(run.session)
        session.pulse, session.clock = pulse, time.monotonic
        for name, participant in work.simulation.assembly.participants.items():
            component = participant.component
            if isinstance(component, DeviceComponent):
                control = participant.period / work.rate
                written = work.simulation.scenario.components[name].parameters
                session.number = len(devices)
                devices.append(component.open(control, session, dict(written)))
                session.ready[name] = devices[-1]
        ending = supervise(devices, lambda: _loop(run, work, pulse), pulse)
        _say(work.pipe, ending)
        sentences = ending.sentences(devices)
        if ending.status in {0, 1, 2}:
            sentences = sentences[1:] if ending.reason else sentences
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


def _loop(run: PacedRun, work: _Work, pulse: Pulse) -> int:
    """The control loop's process."""
    stop = [False]

    def note(*_: object) -> None:
        stop[0] = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, note)
    deadlines = Deadlines()
    report = LoopReport()
    pacer = RealtimePacer(
        tick_seconds=1 / work.rate,
        policy=run.policy,
        pulse=pulse,
        stopping=lambda: stop[0],
        deadlines=deadlines,
    )
    prepared = _Prepared(pacer, lambda: report.grants.extend(prepare_loop(cpu=run.cpu)))
    status = 0
    try:
        report.outcome = work.simulation.run(
            RelaySink(work.rings, lambda: _say(work.pipe, "begun")), pacer=prepared
        )
    except CohapticError as error:
        status = error.exit_status
        report.error = (status, str(error))
        report.outcome = work.simulation.outcome
    finally:
        pulse.state(FINISHED)
    report.deadlines = deadlines.summary()
    _say(work.pipe, report)
    return status


@dataclass(slots=True)
class _Prepared:
    """The pacer, with the process made real-time just before the first tick.

    Not earlier: setting up FMUs and devices takes longer than a real-time loop may run on end.
    """

    pacer: RealtimePacer
    prepare: Callable[[], None]

    def start(self, tick: int) -> None:
        self.prepare()
        self.pacer.start(tick)

    def wait(self, tick: int) -> None:
        self.pacer.wait(tick)


@contextlib.contextmanager
def _ignoring_interrupts() -> Generator[None]:
    """Ctrl-C reaches the loop by itself, which ends the run at its next tick."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _say(pipe: int, message: Any) -> None:
    data = pickle.dumps(message)
    frame = len(data).to_bytes(8, "little") + data
    while frame:
        frame = frame[os.write(pipe, frame) :]


def _split(data: bytes) -> list[Any]:
    """Whole messages, then the bytes that are left."""
    found: list[Any] = []
    while len(data) >= 8 and len(data) >= 8 + (size := int.from_bytes(data[:8], "little")):
        found.append(pickle.loads(data[8 : 8 + size]))
        data = data[8 + size :]
    return [*found, data]
