"""``odrive+socketcan://can0?nodes=0,1``: two ODrive axes on CAN, one node a joint.

Encoder estimates come cyclically, so what is read at a tick may be a tick old. Any frame to an axis
feeds its watchdog: nothing is polled, and after a fault nothing is sent once the axes are idle.
Axis heartbeats have to come at least every 10 ms (``heartbeat_msg_rate_ms``), estimates every 1 ms.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import ceil, pi
from typing import ClassVar

from cosim.base.errors import InputError
from hil.device.contract import ZERO, BusUse, Received, Sample, Watchdog
from hil.device.driver import Driver
from hil.device.errors import BoardError, DeviceError
from hil.drivers.halves import send_each
from hil.drivers.odrive import protocol as wire
from hil.drivers.odrive.protocol import OdriveCommand, identifier
from hil.drivers.odrive.settings import OdriveOptions, OdriveSettings
from hil.drivers.samples import sample_of_turns
from hil.safety.conversion import TorqueDrive
from hil.safety.linkage import Pair
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.setup.options import read_options
from hil.wire.can_bus import CanBus, open_bus
from hil.wire.ownership import OwnedNodes

FRAMES = (8, 4, 8, 4)
"""Data bytes on the bus in a tick: estimates and torque, per axis."""
LONGEST_SILENCE = 0.030
"""An axis that has sent no heartbeat for so long (s) is lost; they come every 10 ms."""
WAIT_TICKS = 400
"""Exchanges within which an axis has to answer during set-up."""


class OdriveDriver(Driver):
    """Two axes in torque mode."""

    driver = "odrive"
    settings = OdriveSettings
    options = OdriveOptions
    latency_ticks: ClassVar[int] = 1
    emulator = "hil.drivers.odrive.emulator:make"
    found_on = "can"

    _bus: CanBus | None = None
    _owned: OwnedNodes | None = None

    @classmethod
    def bus_use(cls, address: DeviceAddress, file: DeviceFile) -> BusUse:
        """Both axes' estimates and torques."""
        del file
        return BusUse(FRAMES, nodes=read_options(OdriveOptions, address).nodes)

    @property
    def watchdog(self) -> Watchdog:
        """Off in a new ODrive; verified once it was seen to fire."""
        timeout = self.file.settings_of(OdriveSettings).watchdog.timeout
        if timeout is None:
            return Watchdog()
        return Watchdog(timeout=timeout, verified=self.watchdog_proved(timeout))

    def open(self) -> None:
        self._nodes = read_options(OdriveOptions, self.address).nodes
        self._seen = dict.fromkeys(self._nodes, 0)
        self._beats = dict.fromkeys(self._nodes, 0)
        self._silence = dict.fromkeys(self._nodes, 0)
        self._silent_ticks = ceil(LONGEST_SILENCE / self.tick)
        self._running = False
        self._expired_bit = wire.WATCHDOG_EXPIRED[self.file.settings_of(OdriveSettings).firmware]
        self._states = dict.fromkeys(self._nodes, 0)
        self._expired: set[int] = set()
        self._sequence, self._closed = 0, False
        self._bus = open_bus(self.address, self.pulse)
        self._owned = self._bus.own(self._nodes)
        self._bus.join(self, FRAMES, 1 / self.tick)
        for node in self._nodes:
            self._to(node, OdriveCommand.SET_TORQUE, wire.set_torque(0.0))
            self._to(node, OdriveCommand.SET_STATE, wire.set_state(wire.IDLE))
            self._to(node, OdriveCommand.CLEAR_ERRORS)
            self._to(node, OdriveCommand.SET_MODES, wire.set_modes())
            self._to(node, OdriveCommand.SET_LIMITS, self._limits())
            self._set_watchdog(node)
        self._bus.keep_step()
        self._until(self._is_heard, "was never heard: no axis has that node number, or no power")
        self._until(lambda node: self._states[node] == wire.IDLE, "does not report to be idle")
        self._until(self._is_measured, "sends no encoder estimates")
        self._running = True

    def _limits(self) -> bytes:
        turns = self.file.limits.joint_speed / (2 * pi)
        return wire.set_limits(turns, self.file.settings_of(OdriveSettings).current_limit)

    def _set_watchdog(self, node: int) -> None:
        given = self.file.settings_of(OdriveSettings).watchdog
        if given.timeout is None:
            return
        for endpoint, value in (
            (given.timeout_endpoint, given.timeout),
            (given.enable_endpoint, True),
        ):
            if endpoint is not None:
                self._to(node, OdriveCommand.WRITE_ENDPOINT, wire.write_endpoint(endpoint, value))

    def receive(self) -> Received:
        bus = self._opened()
        bus.collect(self)
        told = self._take_heartbeats(bus)
        sample, fast = self._estimates(bus)
        return replace(told, sample=sample, error=told.error or fast)

    def _estimates(self, bus: CanBus) -> tuple[Sample | None, BoardError | None]:
        """The newest positions; what is wrong where a speed cannot be that of a handle."""
        turns: list[float] = []
        seen: dict[int, int] = {}
        fast: BoardError | None = None
        for node in self._nodes:
            frame = bus.received.latest(identifier(node, OdriveCommand.ESTIMATES))
            if frame is None or frame[0] == self._seen[node]:
                continue
            seen[node], (turn, rate) = frame[0], wire.estimates(frame[1])
            turns.append(turn)
            if abs(rate) * 2 * pi > self.file.limits.joint_speed:
                fast = BoardError(
                    f"ODrive axis {node} says that it turns at {rate * 2 * pi:.3g} rad/s, more "
                    "than its joint_speed: its encoder, or its estimator, is wrong"
                )
        if len(seen) < len(self._nodes):  # of one alone there is no sample
            return None, fast
        self._seen = seen
        self._sequence += 1
        return sample_of_turns(self.file.joints, (turns[0], turns[1]), self._sequence), fast

    def _take_heartbeats(self, bus: CanBus) -> Received:
        """What the axes say of themselves."""
        fresh, fired, astray = 0, False, ""
        wrong: BoardError | None = None
        for node in self._nodes:
            frame = bus.received.latest(identifier(node, OdriveCommand.HEARTBEAT))
            if frame is None or frame[0] == self._beats[node]:
                wrong = self._missing(node) or wrong
                continue
            self._beats[node], self._silence[node] = frame[0], 0
            error, self._states[node] = wire.heartbeat(frame[1])
            fresh += 1
            fired |= self._has_expired(node, error)
            if not self._closed:
                error &= ~self._expired_bit  # an idle axis that nobody talks to; it is cleared
            if error:
                wrong = BoardError(f"ODrive axis {node} reports error 0x{error:08x}")
            elif self._closed and self._states[node] != wire.CLOSED_LOOP:
                state = wire.state_name(self._states[node])
                wrong = BoardError(f"ODrive axis {node} left closed loop, it is {state}")
            elif not self._closed and self._states[node] != wire.IDLE:
                state = wire.state_name(self._states[node])
                astray = f"ODrive axis {node} was told to be idle, and is {state}"
        return Received(
            # Out of closed loop nobody sends a torque, so an idle axis is one at zero.
            zero_confirmed=bool(fresh)
            and not self._closed
            and set(self._states.values()) == {wire.IDLE},
            watchdog_fired=fired,
            contradiction=astray if fresh else None,
            error=wrong,
        )

    def _missing(self, node: int) -> BoardError | None:
        """One more tick without a heartbeat; what is wrong once that were too many."""
        self._silence[node] += 1
        if not self._running or self._silence[node] <= self._silent_ticks:
            return None
        return BoardError(
            f"the heartbeat of ODrive axis {node} has been missing for {self._silence[node]} "
            "ticks: set its 'heartbeat_msg_rate_ms' to 10, and look at its supply and its cable"
        )

    def silence(self) -> str | None:
        return self._opened().complaint

    def _has_expired(self, node: int, error: int) -> bool:
        """Whether by now the watchdogs of both axes have fired in closed loop."""
        if not (self._closed and error & self._expired_bit):
            self._expired.discard(node)
            return False
        self._expired.add(node)
        return len(self._expired) == len(self._nodes)

    def send(self, torque: Pair) -> Pair:
        first, second = (_drive(joint.drive) for joint in self.file.joints)
        codes = first.encode(torque[0]), second.encode(torque[1])
        sent = first.decode(codes[0]), second.decode(codes[1])
        parts = [
            ((joint,), identifier(node, OdriveCommand.SET_TORQUE), wire.set_torque(codes[joint]))
            for joint, node in enumerate(self._nodes)
        ]
        send_each(self._opened().send, sent, parts)
        return sent

    def send_zero(self) -> bool:
        """Zero, then idle; silence afterwards, because any frame would feed the watchdog."""
        self._closed = False
        for node in self._nodes:
            if self._states[node] != wire.IDLE:
                self._to(node, OdriveCommand.SET_TORQUE, wire.set_torque(0.0))
                self._to(node, OdriveCommand.SET_STATE, wire.set_state(wire.IDLE))
        return True

    def enter(self) -> None:
        for node in self._nodes:
            self._to(node, OdriveCommand.CLEAR_ERRORS)
            self._to(node, OdriveCommand.SET_TORQUE, wire.set_torque(0.0))
            self._to(node, OdriveCommand.SET_STATE, wire.set_state(wire.CLOSED_LOOP))
        self._until(
            lambda node: self._states[node] == wire.CLOSED_LOOP,
            "does not enter closed loop (is it calibrated?)",
            keep=lambda: self.send(ZERO),
        )
        self._closed = True

    def leave(self) -> None:
        self.send_zero()

    def take_over(self) -> None:
        self._states = dict.fromkeys(self._nodes, 0)
        self._opened().take_over()

    def close(self) -> None:
        if self._owned is not None:
            self._owned.close()
            self._owned = None
        if self._bus is not None:
            self._bus.leave(self)
            self._bus = None

    def _until(
        self, done: Callable[[int], bool], otherwise: str, keep: Callable[[], object] | None = None
    ) -> None:
        """Exchange until it is true of both axes; those of which it does not become are named."""
        for _ in range(WAIT_TICKS):
            told = self.receive()
            if told.error is not None:
                raise told.error
            if all(map(done, self._nodes)):
                return
            if keep is not None:
                keep()
            self.pause()
        named = " and ".join(f"axis {node}" for node in self._nodes if not done(node))
        raise DeviceError(f"{self.name}: {named} {otherwise}")

    def _is_heard(self, node: int) -> bool:
        return self._beats[node] > 0

    def _is_measured(self, node: int) -> bool:
        return self._opened().received.latest(identifier(node, OdriveCommand.ESTIMATES)) is not None

    def _to(self, node: int, command: OdriveCommand, data: bytes = b"") -> None:
        self._opened().send(identifier(node, command), data)

    def _opened(self) -> CanBus:
        assert self._bus is not None, "configure comes first"
        return self._bus


def _drive(drive: object) -> TorqueDrive:
    if not isinstance(drive, TorqueDrive):
        raise InputError("an ODrive takes torque: its 'drive' has a gear and a direction")
    return drive
