"""``canopen+socketcan://can0?nodes=1``: CiA 406 encoders and CiA 401 analogue outputs on CAN.

One SYNC a tick: positions are sampled at it and come back in the same tick; outputs take over their
values on reception. Nodes are set up by ``hil.canopen``; here there are raw frames only.
From activation on the nodes with outputs watch our heartbeat and drop to zero without it. A node
that starts anew, changes state or falls silent un-homes the device; an emergency ends in FAULT.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import count
from math import ceil
from time import monotonic
from typing import ClassVar

from cosim.base.errors import InputError
from hil.device.contract import ZERO, BusUse, Received, Watchdog
from hil.device.driver import Driver
from hil.device.errors import ActivationRefused, BoardError, DeviceError, NodeLost
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.protocol import Index, NmtCommand, NmtState, Object, SdoAnswer
from hil.drivers.canopen.set_up import CanopenTiming, set_up
from hil.drivers.canopen.settings import (
    WATCHDOG_MS,
    CanopenOptions,
    CanopenSettings,
    layout_of,
    settings,
)
from hil.drivers.canopen.supervision import Events, Supervision, told_under
from hil.drivers.canopen.zero_check import ZeroCheck
from hil.drivers.samples import sample_of_counts
from hil.safety.linkage import Pair
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.wire.can_bus import CanBus, open_bus
from hil.wire.ownership import OwnedNodes
from hil.wire.serial_port import PATIENCE

SYNC_FRAME = (0,)
"""Data bytes of what is sent once for all devices on a bus."""
HEARTBEAT_MISSING = 0x8130
"""Emergency code of a node that misses our heartbeat (CiA 301)."""
MISSED_HEARTBEATS = 3
ASK_AGAIN_TICKS = 128
"""A frame may have been lost; the same SDO request may come twice."""
SETUP_TICKS = 1024
"""Exchanges within which a node has to do what it was asked, outside the loop."""
PRESET_TOLERANCE = 0.1
"""How far the handle may have moved while its position was preset (rad)."""


class CanopenDriver(Driver):
    """Two joints on one to three nodes."""

    driver = "canopen"
    settings = CanopenSettings
    options = CanopenOptions
    latency_ticks: ClassVar[int] = 0
    emulator = "hil.drivers.canopen.emulator:make"
    command_unit = "V"
    found_on = "can"

    heartbeat = wire.LAST_NODE
    """The node number of our heartbeat, which the nodes with outputs watch."""
    _bus: CanBus | None = None
    _owned: OwnedNodes | None = None
    _watchdog_ms = WATCHDOG_MS
    _proved = False

    @classmethod
    def bus_use(cls, address: DeviceAddress, file: DeviceFile) -> BusUse:
        """A PDO of positions or values for each node, and the bus's one SYNC."""
        layout = layout_of(address, file)
        return BusUse(layout.frames, shared=SYNC_FRAME, nodes=layout.nodes)

    @property
    def knows_its_pose(self) -> bool:
        """As its settings say."""
        return self.file.settings_of(CanopenSettings).absolute

    @property
    def watchdog(self) -> Watchdog:
        """The nodes' heartbeat consumers with zero on error, written and read back."""
        return Watchdog(timeout=self._watchdog_ms * 1e-3, verified=self._proved)

    # --- setting up ------------------------------------------------------------------------------

    def open(self) -> None:
        self._settings = given = settings(self.address, self.file, self.tick)
        self._layout, self._drives, self._zero_codes = given.layout, given.drives, given.zero_codes
        self._heartbeat_ms, self._watchdog_ms = given.heartbeat_ms, given.watchdog_ms
        self._beat_ticks = max(1, int(self._heartbeat_ms * 1e-3 / self.tick))
        self._silent_ticks = ceil(MISSED_HEARTBEATS * self._heartbeat_ms * 1e-3 / self.tick)
        self._proved = self._running = self._armed = False
        self._begin()
        bus = self._joined()
        timing = CanopenTiming(
            heartbeat_ms=self._heartbeat_ms,
            watchdog_ms=self._watchdog_ms,
            producer=self.heartbeat,
            timeout=PATIENCE if self.lockstep else given.timeout,
        )
        first, second = self.file.joints
        found = set_up(
            bus,
            self._layout,
            timing,
            (first.counts_per_turn, second.counts_per_turn),
            self._zero_codes,
        )
        self._ranges, self._number, self._proved = found.ranges, found.serial, True
        self._begin()
        bus.keep_step()
        self._until(lambda: self._nodes.all_operational, "its nodes do not become operational")
        self._until(lambda: self._sequence > 0, "its encoders send no positions on SYNC")
        self._running = True

    def _begin(self) -> None:
        """What is known of the nodes at the start: nothing."""
        self._nodes = Supervision(self._layout.nodes, self._silent_ticks)
        self._zero_check = ZeroCheck(self._layout.outputs, self._zero_codes)
        self._expired: set[int] = set()
        self._sequence = self._since_beat = 0
        self._beat_time = 0.0
        self._forget_positions()
        self._answers: dict[int, SdoAnswer] = {}
        self._cold = False
        """Whether all outputs were seen at zero since a torque was last sent."""

    def _joined(self) -> CanBus:
        bus = open_bus(self.address, self.pulse)
        try:
            self._check_bus(bus)
            self._owned = bus.own(self._layout.nodes)
            bus.extra = SYNC_FRAME
            bus.join(self, self._layout.frames, 1 / self.tick)
        except (InputError, DeviceError):
            bus.leave(self)
            raise
        self._bus = bus
        bus.begin_tick = partial(bus.send, wire.SYNC)
        bus.awaited.update(wire.positions_id(node) for node in self._layout.measuring)
        for node in self._layout.nodes:
            bus.events.update({name: [] for name in told_under(node)})
        own = [wire.NMT, wire.SYNC, wire.heartbeat_id(self.heartbeat)]
        own += [wire.sdo_request_id(node) for node in self._layout.nodes]
        bus.claim([*own, *(wire.outputs_id(node) for node in self._layout.driving)])
        return bus

    def _check_bus(self, bus: CanBus) -> None:
        """Who else is on it? Our heartbeat gets a number that no other device on it uses."""
        if bus.users and bus.begin_tick is None:
            raise InputError(f"{bus.name} carries another protocol; CANopen needs a bus of its own")
        for node in self._layout.nodes:
            if wire.heartbeat_id(node) in bus.events:
                raise InputError(f"CANopen node {node} on {bus.name} belongs to another device")
        others = {each.heartbeat for each in bus.users if isinstance(each, CanopenDriver)}
        self.heartbeat = next(n for n in range(wire.LAST_NODE, 0, -1) if n not in others)
        if self.heartbeat in self._layout.nodes:
            raise InputError(f"node number {self.heartbeat} is our own heartbeat's; choose another")

    def serial(self) -> str | None:
        return self._number

    # --- every tick ------------------------------------------------------------------------------

    def receive(self) -> Received:
        bus = self._opened()
        bus.collect(self)
        confirmed = self._take_answers(bus)
        events = self._nodes.take(bus)
        fired = self._has_expired(events)
        raw, sample = self._positions(bus), None
        if raw is not None:
            for joint in (0, 1):
                self._unwrap(joint, raw[joint])
            self._sequence += 1
            units = self._units[0], self._units[1]
            sample = sample_of_counts(self.file.joints, units, self._sequence)
        return Received(
            sample=sample,
            zero_confirmed=confirmed,
            watchdog_fired=fired,
            error=self._wrong(events) if self._running else None,
        )

    def silence(self) -> str | None:
        return self._opened().complaint

    def _positions(self, bus: CanBus) -> dict[int, int] | None:
        """Positions by joint, of this tick's SYNC and nothing else; all of them or none."""
        found: dict[int, int] = {}
        for node in self._layout.measuring:
            joints = self._layout.joints_measured(node)
            data = bus.answer(wire.positions_id(node))
            if data is None:
                return None
            found.update(zip(joints, wire.positions(data, len(joints)), strict=True))
        return found

    def _forget_positions(self) -> None:
        """The next position is not to be compared with the last one."""
        self._last, self._units = [0, 0], [0, 0]

    def _unwrap(self, joint: int, raw: int) -> None:
        """Follow a position over the end of its range."""
        self._units[joint] += wire.step(self._last[joint], raw, self._ranges[joint])
        self._last[joint] = raw

    def _has_expired(self, events: Events) -> bool:
        """Whether by now every node with outputs has missed our heartbeat."""
        missed = {n for n, report in events.reports.items() if report.code == HEARTBEAT_MISSING}
        self._expired |= missed
        return bool(missed) and self._expired.issuperset(self._layout.driving)

    def _wrong(self, events: Events) -> DeviceError | None:
        """A node that is lost un-homes the device; an emergency says what is wrong."""
        if events.lost is not None:
            return NodeLost(events.said)
        return BoardError(events.said) if events.reports else None

    def send(self, torque: Pair) -> Pair:
        codes = self._drives[0].encode(torque[0]), self._drives[1].encode(torque[1])
        self._zero_check.forget()
        self._cold = False
        self._put(codes)
        if self._armed:
            self._since_beat += 1
            if self._since_beat >= self._beat_ticks or self._late():
                self._beat()
        return self._drives[0].decode(codes[0]), self._drives[1].decode(codes[1])

    def feed(self) -> None:
        self.send(ZERO)
        self._beat()

    def _late(self) -> bool:
        """Whether the loop's ticks take longer than they should: heartbeats go by the clock."""
        return not self.lockstep and monotonic() - self._beat_time > self._heartbeat_ms * 1e-3

    def _beat(self) -> None:
        data = wire.heartbeat(NmtState.OPERATIONAL)
        self._opened().send(wire.heartbeat_id(self.heartbeat), data)
        self._since_beat, self._beat_time = 0, monotonic()

    def _put(self, codes: tuple[int, int]) -> None:
        for node in self._layout.driving:
            values = [codes[joint] for joint in self._layout.joints_driven(node)]
            self._opened().send(wire.outputs_id(node), wire.outputs(values))

    def send_zero(self) -> bool:
        """Zero without a heartbeat, so that the nodes' own zero follows; then ask for it back."""
        self._put(self._zero_codes)
        question = self._zero_check.question(urgent=not self._cold)
        if question is not None:
            node, request = question
            self._opened().send(wire.sdo_request_id(node), request)
        return True

    def _take_answers(self, bus: CanBus) -> bool:
        """Whether an answer completes a round in which every output was at zero."""
        confirmed = False
        for node in self._layout.nodes:
            for data in bus.taken(wire.sdo_answer_id(node)):
                self._answers[node] = answer = wire.sdo_answer(data)
                confirmed |= self._zero_check.take(node, answer)
        self._cold |= confirmed
        return confirmed

    # --- life cycle ------------------------------------------------------------------------------

    def set_home(self, home: Pair) -> None:
        """Make positions count from joint angle zero, unless ``settings.preset`` is false."""
        if not self._settings.preset:
            return
        for encoder, joint, angle, span in zip(
            self._layout.encoders, self.file.joints, home, self._ranges, strict=True
        ):
            wanted = round(joint.direction * angle / joint.quantum)
            self._write(encoder.node, encoder.preset, wanted % span)
        self._forget_positions()
        seen = self._sequence
        self._until(lambda: self._sequence > seen, "its encoders send no positions on SYNC")
        for joint, angle, units in zip(self.file.joints, home, self._units, strict=True):
            found = units * joint.quantum
            if abs(found - joint.direction * angle) > PRESET_TOLERANCE:
                raise DeviceError(
                    f"{self.name} did not take the preset {angle:.4f} rad, it shows "
                    f"{joint.direction * found:.4f} rad"
                )

    def enter(self) -> None:
        """Have the nodes with outputs watch our heartbeat, which begins with the first command."""
        for node in self._layout.driving:
            entry = Object(Index.HEARTBEAT_CONSUMER, 1, 4)
            value = wire.consumer(self.heartbeat, self._watchdog_ms)
            self._write(node, entry, value)
            if self._read(node, entry) != value:
                raise ActivationRefused(f"CANopen node {node} does not watch our heartbeat")
        self._armed, self._since_beat = True, self._beat_ticks

    def leave(self) -> None:
        """Nobody has to watch a heartbeat that is about to end; who missed one starts again."""
        if not self._armed:
            return
        self._armed = False
        if self._expired:
            self._beat()
        for node in self._layout.driving:
            self._write(node, Object(Index.HEARTBEAT_CONSUMER, 1, 4), 0)
        for node in self._expired:
            self._opened().send(wire.NMT, wire.nmt(NmtCommand.START, node))
        self._until(lambda: self._nodes.all_operational, "its nodes do not start again")
        self._expired.clear()

    def take_over(self) -> None:
        self._opened().take_over()
        self._begin()

    def close(self) -> None:
        if self._owned is not None:
            self._owned.close()
            self._owned = None
        bus, self._bus = self._bus, None
        if bus is None:
            return
        for node in self._layout.nodes:
            bus.awaited.discard(wire.positions_id(node))
            for name in told_under(node):
                bus.events.pop(name, None)
        bus.leave(self)

    # --- outside the loop ------------------------------------------------------------------------

    def _write(self, node: int, entry: Object, value: int) -> None:
        self._ask(node, entry, wire.sdo_download(entry, value))

    def _read(self, node: int, entry: Object) -> int | None:
        return self._ask(node, entry, wire.sdo_upload(entry)).value

    def _ask(self, node: int, entry: Object, request: bytes) -> SdoAnswer:
        """One SDO exchange by raw frames, between two ticks."""
        self._zero_check.forget()
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
            self.receive()
            if done():
                return
            self.pause()
        raise DeviceError(f"{self.name}: {otherwise}")

    def _opened(self) -> CanBus:
        assert self._bus is not None, "configure comes first"
        return self._bus
