"""What every driver of CANopen nodes does: join the bus, watch nodes, beat, and ask by SDO.

Raw frames alone; nodes are set up before by ``hil.drivers.canopen.remote``.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Generator
from contextlib import contextmanager
from functools import partial
from itertools import count
from math import ceil
from time import monotonic

from cosim.base.errors import InputError
from hil.device.driver import Driver
from hil.device.errors import ActivationRefused, BoardError, DeviceError
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.protocol import Index, NmtCommand, NmtState, Object, SdoAnswer
from hil.drivers.canopen.remote import CanopenTiming
from hil.drivers.canopen.settings import is_pipelined
from hil.drivers.canopen.supervision import Events, Supervision, told_under
from hil.setup.address import DeviceAddress
from hil.wire.can_bus import CanBus, open_bus
from hil.wire.ownership import OwnedNodes
from hil.wire.serial_port import PATIENCE

SYNC_FRAME = (0,)
"""Data bytes of what is sent once for all devices on a bus."""
MISSED_HEARTBEATS = 3
ASK_AGAIN_TICKS = 128
"""A frame may have been lost; the same SDO request may come twice."""
SETUP_TICKS = 1024
"""Exchanges within which a node has to do what it was asked, outside the loop."""


class CanopenMaster(Driver):
    """Nodes on a bus with one SYNC a tick; what their process data means is the driver's.

    ``_numbers`` are the nodes, ``_measuring`` and ``_driving`` those that send and take process
    data, and ``_frames`` the data bytes of a tick's frames besides SYNC.
    """

    heartbeat = wire.LAST_NODE
    """The node number of our heartbeat, which the nodes with outputs watch."""
    expiry_code = wire.HEARTBEAT_MISSING
    """Emergency code of a node whose watchdog has fired."""
    _bus: CanBus | None = None
    _owned: OwnedNodes | None = None
    _numbers: tuple[int, ...] = ()
    _measuring: tuple[int, ...] = ()
    _driving: tuple[int, ...] = ()
    _frames: tuple[int, ...] = ()
    _heartbeat_ms = 0
    _watchdog_ms = 0
    _beat_ticks = 1
    _silent_ticks = 1
    _armed = False
    """Whether the nodes with outputs watch us, so that we beat."""
    _forgiving = False
    """Whether nodes that have missed us are made well again: what they say of it is no news."""

    @classmethod
    def latency_of(cls, address: DeviceAddress) -> int:
        """One tick more where answers are read at the tick after their SYNC."""
        return cls.latency_ticks + is_pipelined(address)

    def _begin(self) -> None:
        """What is known of the nodes at the start: nothing."""
        self._nodes = Supervision(self._numbers, self._silent_ticks)
        self._expired: set[int] = set()
        self._since_beat, self._beat_time = 0, 0.0
        self._answers: dict[int, SdoAnswer] = {}

    def _time(self, heartbeat_ms: int, watchdog_ms: int) -> None:
        """How often nodes and we say that we are alive, in ms, and in ticks from here on."""
        self._heartbeat_ms, self._watchdog_ms = heartbeat_ms, watchdog_ms
        self._beat_ticks = max(1, int(heartbeat_ms * 1e-3 / self.tick))
        self._silent_ticks = ceil(MISSED_HEARTBEATS * heartbeat_ms * 1e-3 / self.tick)

    def _timing(self, timeout: float) -> CanopenTiming:
        """What nodes are set up to; ``timeout`` (s) is for an answer that no emulator owes."""
        return CanopenTiming(
            heartbeat_ms=self._heartbeat_ms,
            watchdog_ms=self._watchdog_ms,
            producer=self.heartbeat,
            timeout=PATIENCE if self.lockstep else timeout,
        )

    @abstractmethod
    def _forget_answers(self) -> None:
        """A question of somebody else's is under way: no answer says that the torque is zero."""

    def _between(self) -> None:
        """In each exchange outside the loop: what has to go on meanwhile."""

    def _joined(self) -> CanBus:
        bus = open_bus(self.address, self.pulse)
        try:
            self._check_bus(bus)
            self._owned = bus.own(self._numbers)
            bus.extra = SYNC_FRAME
            bus.join(self, self._frames, 1 / self.tick)
        except (InputError, DeviceError):
            bus.leave(self)
            raise
        self._bus = bus
        bus.pipelined = is_pipelined(self.address)
        bus.begin_tick = partial(bus.send, wire.SYNC)
        bus.awaited.update(wire.positions_id(node) for node in self._measuring)
        for node in self._numbers:
            bus.received.events.update({name: [] for name in told_under(node)})
        own = [wire.NMT, wire.SYNC, wire.heartbeat_id(self.heartbeat)]
        own += [wire.sdo_request_id(node) for node in self._numbers]
        bus.received.claim([*own, *(wire.outputs_id(node) for node in self._driving)])
        return bus

    def _check_bus(self, bus: CanBus) -> None:
        """Who else is on it? Our heartbeat gets a number that no other device on it uses."""
        if bus.users and bus.begin_tick is None:
            raise InputError(f"{bus.name} carries another protocol; CANopen needs a bus of its own")
        for node in self._numbers:
            if wire.heartbeat_id(node) in bus.received.events:
                raise InputError(f"CANopen node {node} on {bus.name} belongs to another device")
        if bus.users and bus.pipelined is not is_pipelined(self.address):
            raise InputError(
                f"{self.name} and another device on {bus.name} disagree about 'pipelined': a bus "
                "has one SYNC a tick; write the same in both URLs"
            )
        others = {each.heartbeat for each in bus.users if isinstance(each, CanopenMaster)}
        self.heartbeat = next(n for n in range(wire.LAST_NODE, 0, -1) if n not in others)
        if self.heartbeat in self._numbers:
            raise InputError(f"node number {self.heartbeat} is our own heartbeat's; choose another")

    def _has_expired(self, events: Events) -> bool:
        """Whether by now every node with outputs has reported that its watchdog fired."""
        missed = {n for n, report in events.reports.items() if report.code == self.expiry_code}
        self._expired |= missed
        return bool(missed) and self._expired.issuperset(self._driving)

    def _refused(self, events: Events) -> DeviceError | None:
        """What a node reports while it is set up; that it missed us is none, its watch is tried."""
        watches = {wire.HEARTBEAT_MISSING, wire.RPDO_MISSING}
        others = {n: each for n, each in events.reports.items() if each.code not in watches}
        return BoardError(Events(reports=others).said) if others else None

    def _late(self) -> bool:
        """Whether the loop's ticks take longer than they should: heartbeats go by the clock."""
        return not self.lockstep and monotonic() - self._beat_time > self._heartbeat_ms * 1e-3

    def _beat_if_due(self) -> None:
        """One more tick in which the nodes watch us."""
        if self._armed:
            self._since_beat += 1
            if self._since_beat >= self._beat_ticks or self._late():
                self._beat()

    def _beat(self) -> None:
        data = wire.heartbeat(NmtState.OPERATIONAL)
        self._opened().send(wire.heartbeat_id(self.heartbeat), data)
        self._since_beat, self._beat_time = 0, monotonic()

    def _watch_us(self, *, milliseconds: int) -> None:
        """Have the nodes with outputs watch our heartbeat; 0 ends that.

        Raises:
            ActivationRefused: one of them does not.
        """
        value = wire.consumer(self.heartbeat, milliseconds) if milliseconds else 0
        for node in self._driving:
            entry = Object(Index.HEARTBEAT_CONSUMER, 1, 4)
            self._write(node, entry, value)
            if value and self._read(node, entry) != value:
                raise ActivationRefused(f"CANopen node {node} does not watch our heartbeat")

    def _start_again(self) -> None:
        """Those that missed us left Operational."""
        for node in self._expired:
            self._opened().send(wire.NMT, wire.nmt(NmtCommand.START, node))
        self._until(lambda: self._nodes.all_operational, "its nodes do not start again")
        self._expired.clear()

    @contextmanager
    def _forgives(self) -> Generator[None]:
        """Inside, nodes may say that they had missed us, and what it did to them."""
        self._forgiving = True
        try:
            yield
        finally:
            self._forgiving = False

    def _sdo_answers(self, bus: CanBus) -> list[tuple[int, SdoAnswer]]:
        """What the nodes' SDO servers have answered since the last time."""
        found: list[tuple[int, SdoAnswer]] = []
        for node in self._numbers:
            for data in bus.received.taken(wire.sdo_answer_id(node)):
                self._answers[node] = answer = wire.sdo_answer(data)
                found.append((node, answer))
        return found

    def take_over(self) -> None:
        """Forget what was true in the process that died."""
        self._opened().take_over()
        self._begin()

    def close(self) -> None:
        """Leave the bus, which the last one closes; safe when it was never opened."""
        if self._owned is not None:
            self._owned.close()
            self._owned = None
        bus, self._bus = self._bus, None
        if bus is None:
            return
        for node in self._numbers:
            bus.awaited.discard(wire.positions_id(node))
            for name in told_under(node):
                bus.received.events.pop(name, None)
        bus.leave(self)

    # --- outside the loop ------------------------------------------------------------------------

    def _write(self, node: int, entry: Object, value: int) -> None:
        self._ask(node, entry, wire.sdo_download(entry, value))

    def _read(self, node: int, entry: Object) -> int | None:
        return self._ask(node, entry, wire.sdo_upload(entry)).value

    def _ask(self, node: int, entry: Object, request: bytes) -> SdoAnswer:
        """One SDO exchange by raw frames, between two ticks."""
        self._forget_answers()
        self._answers.pop(node, None)
        exchanges = count()

        def answered() -> bool:
            answer = self._answers.get(node)
            if answer is not None and answer.is_for(entry):
                return True
            if next(exchanges) % ASK_AGAIN_TICKS == 0:
                self._opened().send(wire.sdo_request_id(node), request)
            return False

        self._until(answered, f"node {node} does not answer about {entry}")
        answer = self._answers[node]
        if answer.abort:
            raise DeviceError(
                f"CANopen node {node} refuses {entry} (SDO abort 0x{answer.abort:08x})"
            )
        return answer

    def _until(self, done: Callable[[], bool], otherwise: str) -> None:
        for _ in range(SETUP_TICKS):
            error = self.receive().error
            if error is not None and not self._forgiving:
                raise error
            if done():
                return
            self._between()
            self.pause()
        raise DeviceError(f"{self.name}: {otherwise}")

    def _opened(self) -> CanBus:
        assert self._bus is not None, "configure comes first"
        return self._bus
