"""``cobs:///dev/ttyACM0``: boards of your own making that speak the framed protocol of cohaptic.

The device side is ``hil/firmware``. A board answers each command, so reading is a tick behind; it
drops its torque by itself when no valid command has come for ``WATCHDOG_MS``.
"""

from __future__ import annotations

from typing import ClassVar

from cosim.base.errors import InputError
from hil.device.contract import ZERO, Sample, State, Watchdog
from hil.device.device import Device
from hil.device.errors import BoardError, DeviceError
from hil.drivers.cobs.protocol import CommandFlag, Reply, ReplyFlag, Splitter, command, reply
from hil.drivers.samples import sample_of_counts
from hil.safety.conversion import TorqueDrive
from hil.safety.limits import HOLD_TICKS
from hil.safety.linkage import Pair
from hil.wire.serial_port import SerialOptions, SerialPort

WATCHDOG_MS = 20
ANSWER_TRIES = 50


class CobsDevice(Device):
    """Two axes that take torque as a float and answer with encoder counts."""

    driver = "cobs"
    options = SerialOptions
    latency_ticks: ClassVar[int] = 1
    has_input: ClassVar[bool] = True

    _port: SerialPort | None = None

    @property
    def watchdog(self) -> Watchdog:
        """In every command; verified once ``device check`` has seen this board's fire."""
        timeout = WATCHDOG_MS * 1e-3
        return Watchdog(timeout=timeout, verified=self.watchdog_proved(timeout))

    def _open(self) -> None:
        self._port = SerialPort(self.address, self.pulse, self.number)
        self._splitter, self._sequence, self._flags = Splitter(), 0, CommandFlag.CLEAR
        self._newest: Reply | None = None
        self._seen = 0
        for _ in range(ANSWER_TRIES):
            self._send_zero()
            self.pause()
            if self._receive() is not None:
                return
        raise DeviceError(f"no board answers at {self.address.place}")

    def _receive(self) -> Sample | None:
        port = self._opened()
        port.exchange_done()
        newest: Reply | None = None
        for body in self._splitter.feed(port.read()):
            newest = reply(body) or newest
        if newest is None:
            return None
        behind = (self._sequence - newest.sequence) & 0xFFFF
        self._check(newest)
        if behind > HOLD_TICKS:
            return None  # an answer from long ago (or to nobody's question) is no new sample
        self._seen += 1
        return sample_of_counts(
            self.file.joints, newest.count, self._seen, device_time=newest.microseconds * 1e-6
        )

    def _check(self, newest: Reply) -> None:
        if newest.status & ReplyFlag.ZERO and not newest.status & ReplyFlag.ENABLED:
            self.zeros_confirmed += 1
        self.input_held = bool(newest.status & ReplyFlag.INPUT)
        self.watchdog_reports += bool(newest.status & ReplyFlag.WATCHDOG_FIRED)
        if self.state is not State.ACTIVE:
            return
        if newest.status & (ReplyFlag.WATCHDOG_FIRED | ReplyFlag.FAULT):
            raise BoardError(f"the board reports {newest.status!r}")

    def _send(self, tick: int, torque: Pair) -> Pair:
        drives = [_drive(joint.drive) for joint in self.file.joints]
        codes = (drives[0].encode(torque[0]), drives[1].encode(torque[1]))
        self._put(CommandFlag.ENABLE, codes)
        return drives[0].decode(codes[0]), drives[1].decode(codes[1])

    def _send_zero(self) -> None:
        """Zero, and the output stage off; a zero byte first ends whatever was half sent."""
        self._put(self._flags, ZERO)

    def _put(self, flags: CommandFlag, codes: Pair) -> None:
        self._sequence = (self._sequence + 1) & 0xFFFF
        self._opened().write(command(flags, self._sequence, codes, WATCHDOG_MS))

    def _enter(self) -> None:
        self._put(CommandFlag.CLEAR | CommandFlag.ENABLE, ZERO)

    def _take_over(self) -> None:
        self._opened().take_over()
        self._splitter = Splitter()

    def _recover(self) -> None:
        self._opened().write(b"\0")

    def _close(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None

    def _opened(self) -> SerialPort:
        assert self._port is not None, "configure comes first"
        return self._port


def _drive(drive: object) -> TorqueDrive:
    if not isinstance(drive, TorqueDrive):
        raise InputError("this board takes torque: its 'drive' has a gear and a direction only")
    return drive
