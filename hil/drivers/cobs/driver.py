"""``cobs:///dev/ttyACM0``: boards of your own making that speak the framed protocol of cohaptic.

The device side is ``hil/firmware``. A board answers each command, so reading is a tick behind; it
drops its torque by itself when no valid command has come for ``WATCHDOG_MS``.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from cosim.base.errors import InputError
from hil.device.contract import NOTHING, ZERO, Received, Watchdog
from hil.device.driver import Driver
from hil.device.errors import BoardError, DeviceError
from hil.drivers.cobs.protocol import CommandFlag, Reply, ReplyFlag, command, reply
from hil.drivers.samples import WrappingClock, sample_of_counts
from hil.safety.conversion import TorqueDrive
from hil.safety.linkage import Pair
from hil.wire.cobs_frames import Splitter
from hil.wire.serial_port import SerialOptions, SerialPort

WATCHDOG_MS = 20
ANSWER_TRIES = 50
LONGEST_LAG = 2
"""Answers to a command that is older (ticks) are no new sample."""
NOTICEABLE = 0.05
"""A torque of so large a share of the limit cannot be zero at the output stage, however coarse."""


class CobsDriver(Driver):
    """Two axes that take torque as a float and answer with encoder counts."""

    driver = "cobs"
    options = SerialOptions
    latency_ticks: ClassVar[int] = 1
    has_input: ClassVar[bool] = True
    emulator = "hil.drivers.cobs.emulator:make"
    found_on = "serial"

    _port: SerialPort | None = None

    @property
    def watchdog(self) -> Watchdog:
        """In every command; verified once this board's was seen to fire."""
        timeout = WATCHDOG_MS * 1e-3
        return Watchdog(timeout=timeout, verified=self.watchdog_proved(timeout))

    @property
    def port(self) -> SerialPort | None:
        return self._port

    def open(self) -> None:
        self._port = SerialPort(self.address, self.pulse, self.number)
        self._splitter, self._sequence, self._flags = Splitter(), 0, CommandFlag.CLEAR
        self._seen, self._hot = 0, 0
        self._answered = 0
        """The newest command that was answered."""
        self._pushes: dict[int, bool] = {}
        """By command, of those that a new sample can answer: whether it asked for a torque that no
        output stage would round to zero; ``False`` for zero itself."""
        self._clock = WrappingClock()
        gear = max(_drive(joint.drive).gear for joint in self.file.joints)
        self._noticeable = NOTICEABLE * self.file.limits.torque / gear
        for _ in range(ANSWER_TRIES):
            self.send_zero()
            self.pause()
            told = self.receive()
            for each in told.each:
                if each.error is not None:
                    raise each.error
            if told.sample is not None:
                return
        raise DeviceError(f"no board answers at {self.address.place}")

    def receive(self) -> Received:
        port = self._opened()
        port.exchange_done()
        replies = [found for body in self._splitter.feed(port.read()) if (found := reply(body))]
        if not replies:
            return NOTHING
        *earlier, newest = map(self._told, replies)
        return replace(newest, earlier=tuple(earlier))

    def _told(self, one: Reply) -> Received:
        status = one.status
        sample, asked = None, self._was_asked(one)
        if asked and self._is_newer(one):
            # Older, a second time, or to nobody's question, it is no new sample.
            self._seen, self._answered = self._seen + 1, one.sequence
            sample = sample_of_counts(self.file.joints, one.count, self._seen)
        wrong = bool(status & ReplyFlag.FAULT)
        return Received(
            sample=sample,
            zero_confirmed=bool(status & ReplyFlag.ZERO) and self._is_after_torque(one),
            contradiction=self._contradiction(one) if asked else None,
            watchdog_fired=bool(status & ReplyFlag.WATCHDOG_FIRED),
            enabled=bool(status & ReplyFlag.ENABLED),
            input_held=bool(status & ReplyFlag.INPUT),
            device_time=self._clock.seconds(one.microseconds),
            error=BoardError(f"the board reports {status!r}") if wrong else None,
        )

    def _was_asked(self, one: Reply) -> bool:
        """Whether it answers one of the last commands."""
        return (self._sequence - one.sequence) & 0xFFFF <= LONGEST_LAG

    def _is_newer(self, one: Reply) -> bool:
        """Whether that command was not answered before."""
        return 0 < (one.sequence - self._answered) & 0xFFFF < 0x8000

    def _is_after_torque(self, one: Reply) -> bool:
        """Whether it answers something that was sent after the last torque that was not zero."""
        since = (self._sequence - self._hot) & 0xFFFF
        return 0 < (one.sequence - self._hot) & 0xFFFF <= since

    def _contradiction(self, one: Reply) -> str | None:
        """Where it says of its output stage what its command did not ask for."""
        pushes, is_zero = self._pushes.get(one.sequence), bool(one.status & ReplyFlag.ZERO)
        if pushes is None or pushes is not is_zero:
            return ""
        return (
            "the board says that it is at zero, though it was told to push"
            if is_zero
            else "the board says that it is not at zero, though it was told to be"
        )

    def send(self, torque: Pair) -> Pair:
        drives = [_drive(joint.drive) for joint in self.file.joints]
        codes = (drives[0].encode(torque[0]), drives[1].encode(torque[1]))
        self._put(CommandFlag.ENABLE, codes)
        if codes != ZERO:
            self._hot = self._sequence
        return drives[0].decode(codes[0]), drives[1].decode(codes[1])

    def send_zero(self) -> bool:
        """Zero, and the output stage off; a zero byte first ends whatever was half sent."""
        self._put(self._flags, ZERO)
        return True

    def _put(self, flags: CommandFlag, codes: Pair) -> None:
        self._sequence = (self._sequence + 1) & 0xFFFF
        self._remember(codes)
        self._opened().write(command(flags, self._sequence, codes, WATCHDOG_MS))

    def _remember(self, codes: Pair) -> None:
        """What the command with this number asks of the output stage, until nobody answers it."""
        self._pushes.pop((self._sequence - LONGEST_LAG - 1) & 0xFFFF, None)
        largest = max(map(abs, codes))
        if largest == 0.0 or largest > self._noticeable:
            self._pushes[self._sequence] = largest > 0.0

    def enter(self) -> None:
        self._put(CommandFlag.CLEAR | CommandFlag.ENABLE, ZERO)

    def take_over(self) -> None:
        self._opened().take_over()
        self._splitter = Splitter()

    def recover(self) -> None:
        self._opened().write(b"\0")

    def close(self) -> None:
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
