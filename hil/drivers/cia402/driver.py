"""``cia402+socketcan://can0?nodes=1,2``: two CiA 402 drives in torque mode, one node a joint.

One SYNC a tick: state, position and torque demand are sampled at it and come back in the same tick;
controlword and target torque are taken over on reception. From activation on the drives watch our
heartbeat and, by a timer, our commands themselves; either takes their torque off.
"""

from __future__ import annotations

from math import ceil
from typing import ClassVar

from hil.device.contract import ZERO, BusUse, Received, Watchdog
from hil.device.errors import ActivationRefused, BoardError, DeviceError, NodeLost
from hil.drivers.canopen import protocol as wire
from hil.drivers.canopen.master import SYNC_FRAME, CanopenMaster
from hil.drivers.canopen.protocol import Index, Object
from hil.drivers.canopen.settings import LEAST_WATCHDOG_TICKS, is_pipelined
from hil.drivers.canopen.supervision import Events
from hil.drivers.canopen.zero_check import ZeroCheck, ZeroPoint
from hil.drivers.cia402 import protocol as cia
from hil.drivers.cia402.protocol import Controlword, DriveState
from hil.drivers.cia402.set_up import rpdo_timer, set_up_drives
from hil.drivers.cia402.settings import Cia402Options, Cia402Settings
from hil.drivers.cia402.torques import Codes, DriveTorques
from hil.drivers.halves import send_each
from hil.drivers.samples import sample_of_counts
from hil.safety.linkage import Pair
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.setup.options import read_options

ENABLING = (
    (Controlword.SHUTDOWN, DriveState.READY),
    (Controlword.SWITCH_ON, DriveState.SWITCHED_ON),
    (Controlword.ENABLE, DriveState.ENABLED),
)
BROKEN = {DriveState.FAULT, DriveState.FAULT_REACTION, DriveState.QUICK_STOP}


class Cia402Driver(CanopenMaster):
    """Two joints on two drives."""

    driver = "cia402"
    settings = Cia402Settings
    options = Cia402Options
    latency_ticks: ClassVar[int] = 0
    emulator = "hil.drivers.cia402.emulator:make"
    found_on = "can"

    _proved = _running = False

    @classmethod
    def bus_use(cls, address: DeviceAddress, file: DeviceFile) -> BusUse:
        """A command and an answer for each drive, and the bus's one SYNC."""
        return BusUse(_frames(), shared=SYNC_FRAME, nodes=_nodes(address, file))

    @property
    def watchdog(self) -> Watchdog:
        """The drives' timers of our commands, or of our heartbeat; written and read back."""
        return Watchdog(timeout=self._longest_silence() * 1e-3, verified=self._proved)

    def _longest_silence(self) -> int:
        """After how many ms without us a drive takes its torque off."""
        given = self.file.settings_of(Cia402Settings)
        return max(given.watchdog, ceil(LEAST_WATCHDOG_TICKS * self.tick * 1e3))

    # --- setting up ------------------------------------------------------------------------------

    def open(self) -> None:
        given = self.file.settings_of(Cia402Settings)
        self._torques = DriveTorques(self.file)
        self._timed = given.rpdo_timer
        self.expiry_code = wire.RPDO_MISSING if self._timed else wire.HEARTBEAT_MISSING
        self._numbers = self._measuring = self._driving = _nodes(self.address, self.file)
        self._frames = _frames()
        self._time(max(given.heartbeat, ceil(self.tick * 1e3)), self._longest_silence())
        self._proved = self._running = self._armed = False
        self._begin()
        bus = self._joined()
        timing = self._timing(given.timeout)
        first, second = self.file.joints
        found = set_up_drives(
            bus,
            self._numbers,
            timing,
            (first.counts_per_turn, second.counts_per_turn),
            mode=given.mode,
            timed=self._timed,
        )
        self._torques.rated, self._number, self._proved = found.rated, found.serial, True
        self._torques.refuse_coarse(self._numbers)
        self._begin()
        bus.keep_step()
        self._until(lambda: self._nodes.all_operational, "its drives do not become operational")
        self._until(lambda: self._sequence > 0, "its drives send no positions on SYNC")
        self._clear_faults()
        self._running = True

    def _begin(self) -> None:
        super()._begin()
        self._states: dict[int, DriveState] = {}
        self._sequence = 0
        self._last, self._units = [0, 0], [0, 0]
        self._torques.forget()
        self._zero_check = ZeroCheck(
            [
                ZeroPoint(
                    node=node,
                    shown=Object(cia.DEMAND, 0, 2),
                    written=Object(cia.CONTROL, 0, 2),
                )
                for node in self._numbers
            ]
        )
        self._asks = is_pipelined(self.address)
        """Whether a zero is asked back by SDO: answers to a SYNC may be older than a zero."""
        self._told = False
        """Whether the last tick brought process data of all drives."""
        self._cold = False
        """Whether all drives were seen at zero by SDO since a torque was last sent."""
        self._zero_sent = False
        """Whether nothing but zero was sent since the last torque."""
        self._control = Controlword.VOLTAGE_OFF
        self._commanding = False
        """Whether commands have to go on outside the loop, because drives time them."""

    def serial(self) -> str | None:
        return self._number

    # --- every tick ------------------------------------------------------------------------------

    def receive(self) -> Received:
        bus = self._opened()
        bus.collect(self)
        answered = [self._zero_check.take(*each) for each in self._sdo_answers(bus)]
        self._cold |= any(answered)
        events = self._nodes.take(bus)
        fired = self._has_expired(events)
        came = {node: bus.received.answer(wire.positions_id(node)) for node in self._numbers}
        found = {node: cia.answer(data) for node, data in came.items() if data is not None}
        # Of one that is silent the other one's state counts all the same.
        self._states |= {node: state for node, (state, _, _) in found.items()}
        answers = list(found.values())
        self._told = len(answers) == len(self._numbers)
        if not self._told:
            is_off = any(state is not DriveState.ENABLED for state, _, _ in answers)
            return Received(
                zero_confirmed=self._zero_sent and any(answered),
                watchdog_fired=fired,
                enabled=False if is_off else None,
                contradiction=self._zero_check.astray if answered else None,
                error=self._wrong(events) if self._running else self._refused(events),
            )
        for joint, (_, position, _) in enumerate(answers):
            self._units[joint] += wire.step(self._last[joint], position, 1 << 32)
            self._last[joint] = position
        self._sequence += 1
        units = self._units[0], self._units[1]
        return Received(
            sample=sample_of_counts(self.file.joints, units, self._sequence),
            zero_confirmed=self._zero_sent
            and (any(answered) if self._asks else all(demand == 0 for _, _, demand in answers)),
            watchdog_fired=fired,
            enabled=all(state is DriveState.ENABLED for state in self._states.values()),
            contradiction=self._torques.astray(self._numbers, [demand for *_, demand in answers]),
            error=self._wrong(events) if self._running else self._refused(events),
        )

    def silence(self) -> str | None:
        return self._opened().complaint

    def _wrong(self, events: Events) -> DeviceError | None:
        """A node that is lost un-homes the device; an emergency, or a fault, says what is wrong."""
        if events.lost is not None:
            return NodeLost(events.said)
        if events.reports:
            return BoardError(events.said)
        broken = [
            f"CiA 402 drive {node} is in the state '{state.words}'"
            for node, state in self._states.items()
            if state in BROKEN
        ]
        return BoardError("; ".join(broken)) if broken else None

    def send(self, torque: Pair) -> Pair:
        codes = self._torques.codes(torque)
        sent = self._torques.given_by(codes)
        self._zero_sent = codes == (0, 0) and self._zero_sent
        self._cold = False
        self._zero_check.forget()
        self._put(Controlword.ENABLE, codes, sent)
        self._beat_if_due()
        return sent

    def feed(self) -> None:
        self.send(ZERO)
        self._beat()

    def send_zero(self) -> bool:
        """Zero and the voltage off, without a heartbeat; the drives' demand confirms it.

        A drive whose process data do not come, or not in the same tick, is asked by SDO, and told
        so if need be.
        """
        self._put(Controlword.VOLTAGE_OFF, (0, 0))
        self._zero_sent = True
        needed = self._asks or not self._told
        question = self._zero_check.question(urgent=not self._cold) if needed else None
        if question is not None:
            node, request = question
            self._opened().send(wire.sdo_request_id(node), request)
        return True

    def _put(self, control: Controlword, codes: Codes, torque: Pair = ZERO) -> None:
        self._torques.sent(codes)
        parts = [
            ((joint,), wire.outputs_id(node), cia.command(control, codes[joint]))
            for joint, node in enumerate(self._numbers)
        ]
        send_each(self._opened().send, torque, parts)

    # --- life cycle ------------------------------------------------------------------------------

    def enter(self) -> None:
        """From 'switch on disabled' to 'operation enabled', watched from the first step on."""
        self._control, self._commanding = Controlword.VOLTAGE_OFF, True
        self._time_commands(self._watchdog_ms)
        # The second of two watches fires later, so that each is seen by itself.
        self._watch_us(milliseconds=self._watchdog_ms * (2 if self._timed else 1))
        self._armed, self._since_beat = True, self._beat_ticks
        for control, wanted in ENABLING:
            self._control = control
            self._until(
                lambda wanted=wanted: set(self._states.values()) == {wanted},
                f"its drives do not reach the state '{wanted.words}'",
            )
        self._commanding = False

    def leave(self) -> None:
        """Torque off, nobody watches any more, and who missed us is well again."""
        if not self._armed:
            return
        self._control, self._commanding, self._armed = Controlword.VOLTAGE_OFF, True, False
        with self._forgives():
            self._time_commands(0)
            self._watch_us(milliseconds=0)
            self._start_again()
            self._clear_faults()
        self._commanding = False

    def _clear_faults(self) -> None:
        """A fault is taken back by an edge, once its cause is gone."""
        self._commanding = True
        if BROKEN & set(self._states.values()):
            self._control = Controlword.RESET_FAULT
            self._until(
                lambda: not BROKEN & set(self._states.values()), "its drives stay in a fault"
            )
        self._control = Controlword.VOLTAGE_OFF
        seen = self._sequence
        self._until(lambda: self._sequence > seen, "its drives fall silent")
        self._commanding = False

    def _time_commands(self, milliseconds: int) -> None:
        """Have the drives time our commands; 0 ends that.

        Raises:
            ActivationRefused: one of them does not.
        """
        if not self._timed:
            return
        for node in self._numbers:
            identifier = Object(Index.RPDO, 1, 4)
            entry, value = rpdo_timer(milliseconds)
            name = self._read(node, identifier) or wire.outputs_id(node)
            self._write(node, identifier, name | wire.INVALID)
            self._write(node, entry, value)
            kept = self._read(node, entry)
            self._write(node, identifier, name & ~wire.INVALID)
            if kept != value:
                raise ActivationRefused(f"CiA 402 drive {node} does not time our commands")

    def _between(self) -> None:
        if self._commanding:
            self._put(self._control, (0, 0))
            self._beat_if_due()

    def _forget_answers(self) -> None:
        self._zero_check.forget()


def _nodes(address: DeviceAddress, file: DeviceFile) -> tuple[int, ...]:
    return read_options(Cia402Options, address).nodes or file.settings_of(Cia402Settings).nodes


def _frames() -> tuple[int, ...]:
    return (cia.BACK.size,) * 2 + (cia.OUT.size,) * 2
