"""``canopen+socketcan://can0?nodes=1``: CiA 406 encoders and CiA 401 analogue outputs on CAN.

One SYNC a tick: positions are sampled at it and come back in the same tick; outputs take over their
values on reception. Nodes are set up by ``set_up``; here there are raw frames only.
From activation on the nodes with outputs watch our heartbeat and drop to zero without it. A node
that starts anew, changes state or falls silent un-homes the device; an emergency ends in FAULT.
"""

from __future__ import annotations

from typing import ClassVar

from hil.device.contract import ZERO, BusUse, Received, Watchdog
from hil.device.errors import BoardError, DeviceError, NodeLost
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.master import SYNC_FRAME, CanopenMaster
from hil.drivers.canopen.set_up import set_up
from hil.drivers.canopen.settings import (
    WATCHDOG_MS,
    CanopenOptions,
    CanopenSettings,
    layout_of,
    settings,
)
from hil.drivers.canopen.supervision import Events
from hil.drivers.canopen.zero_check import ZeroCheck, ZeroPoint
from hil.drivers.halves import Part, send_each
from hil.drivers.samples import sample_of_counts
from hil.safety.linkage import Pair
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.wire.can_bus import CanBus

PRESET_TOLERANCE = 0.1
"""How far the handle may have moved while its position was preset (rad)."""


class CanopenDriver(CanopenMaster):
    """Two joints on one to three nodes."""

    driver = "canopen"
    settings = CanopenSettings
    options = CanopenOptions
    latency_ticks: ClassVar[int] = 0
    emulator = "hil.drivers.canopen.emulator:make"
    command_unit = "V"
    found_on = "can"

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
        self._numbers, self._frames = given.layout.nodes, given.layout.frames
        self._measuring, self._driving = given.layout.measuring, given.layout.driving
        self._time(given.heartbeat_ms, given.watchdog_ms)
        self._proved = self._running = self._armed = False
        self._begin()
        bus = self._joined()
        timing = self._timing(given.timeout)
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
        super()._begin()
        self._zero_check = ZeroCheck(
            [
                ZeroPoint(node=each.node, shown=each.value, zero=zero, written=each.value)
                for each, zero in zip(self._layout.outputs, self._zero_codes, strict=True)
            ]
        )
        self._sequence = 0
        self._forget_positions()
        self._cold = False
        """Whether all outputs were seen at zero since a torque was last sent."""

    def serial(self) -> str | None:
        return self._number

    # --- every tick ------------------------------------------------------------------------------

    def receive(self) -> Received:
        bus = self._opened()
        bus.collect(self)
        confirmed, astray = self._take_answers(bus)
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
            contradiction=astray,
            error=self._wrong(events) if self._running else self._refused(events),
        )

    def silence(self) -> str | None:
        return self._opened().complaint

    def _forget_answers(self) -> None:
        self._zero_check.forget()

    def _positions(self, bus: CanBus) -> dict[int, int] | None:
        """Positions by joint, of this tick's SYNC and nothing else; all of them or none."""
        found: dict[int, int] = {}
        for node in self._layout.measuring:
            joints = self._layout.joints_measured(node)
            data = bus.received.answer(wire.positions_id(node))
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

    def _wrong(self, events: Events) -> DeviceError | None:
        """A node that is lost un-homes the device; an emergency says what is wrong."""
        if events.lost is not None:
            return NodeLost(events.said)
        return BoardError(events.said) if events.reports else None

    def send(self, torque: Pair) -> Pair:
        codes = self._drives[0].encode(torque[0]), self._drives[1].encode(torque[1])
        sent = self._drives[0].decode(codes[0]), self._drives[1].decode(codes[1])
        self._zero_check.forget()
        self._cold = False
        self._put(codes, sent)
        self._beat_if_due()
        return sent

    def feed(self) -> None:
        self.send(ZERO)
        self._beat()

    def _put(self, codes: tuple[int, int], torque: Pair = ZERO) -> None:
        parts: list[Part] = []
        for node in self._layout.driving:
            joints = self._layout.joints_driven(node)
            data = wire.outputs([codes[joint] for joint in joints])
            parts.append((joints, wire.outputs_id(node), data))
        send_each(self._opened().send, torque, parts)

    def send_zero(self) -> bool:
        """Zero without a heartbeat, so that the nodes' own zero follows; then ask for it back."""
        self._put(self._zero_codes)
        question = self._zero_check.question(urgent=not self._cold)
        if question is not None:
            node, request = question
            self._opened().send(wire.sdo_request_id(node), request)
        return True

    def _take_answers(self, bus: CanBus) -> tuple[bool, str | None]:
        """Whether every output was seen at zero by now; what an answer says of one that is not."""
        confirmed, astray = False, None
        for node, answer in self._sdo_answers(bus):
            confirmed |= self._zero_check.take(node, answer)
            if self._zero_check.astray is not None:
                astray = self._zero_check.astray
        self._cold |= confirmed
        return confirmed, astray

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
        self._watch_us(milliseconds=self._watchdog_ms)
        self._armed, self._since_beat = True, self._beat_ticks

    def leave(self) -> None:
        """Nobody has to watch a heartbeat that is about to end; who missed one starts again."""
        if not self._armed:
            return
        self._armed = False
        if self._expired:
            self._beat()
        with self._forgives():
            self._watch_us(milliseconds=0)
            self._start_again()
