"""``force_sensor:///dev/ttyACM1``: a board that measures force, behind our framed protocol.

It is asked at the end of a tick and answers by the next one; nothing else is ever sent to it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from hil.device.errors import BoardError, DeviceError, ProtocolError
from hil.drivers.force_sensor.preset import KNOWN
from hil.drivers.force_sensor.protocol import (
    VERSION,
    Answer,
    AnswerFlag,
    Identity,
    answer,
    ask,
    identity,
    who,
)
from hil.drivers.samples import WrappingClock
from hil.sensing.reading import SILENT, Heard
from hil.sensing.sensor_driver import SensorDriver
from hil.sensing.sensor_preset import SensorPreset
from hil.wire.cobs_frames import Splitter
from hil.wire.serial_port import SerialOptions, SerialPort

IDENTITY_TRIES = 50
LONGEST_LAG = 2
"""Answers to a question that is older (ticks) are no new sample."""


class ForceSensorDriver(SensorDriver):
    """Up to six channels of raw counts."""

    driver = "force_sensor"
    options = SerialOptions
    known: ClassVar[Mapping[str, SensorPreset]] = KNOWN
    preset = "six_axis"
    emulator = "hil.drivers.force_sensor.emulator:make"
    found_on = "serial"

    _port: SerialPort | None = None
    _identity: Identity | None = None

    @property
    def port(self) -> SerialPort | None:
        """The serial line that it speaks on."""
        return self._port

    def open(self) -> None:
        self._port = SerialPort(self.address, self.pulse, self.number)
        self._splitter, self._sequence, self._clock = Splitter(), 0, WrappingClock()
        self._answered = 0
        """The newest question that was answered."""
        self._identity = found = self._identify()
        if found.version != VERSION:
            raise ProtocolError(
                f"{self.name} speaks version {found.version} of the protocol of sensors, this is "
                f"{VERSION}: renew its firmware"
            )
        if found.channels != len(self.file.channels):
            raise DeviceError(
                f"{self.name} has {found.channels} channels, its file (preset "
                f"'{self.file.preset}') has {len(self.file.channels)}: write them under "
                "'settings: {channels: [...]}'"
            )

    def _identify(self) -> Identity:
        port = self._opened()
        for _ in range(IDENTITY_TRIES):
            self._sequence = (self._sequence + 1) & 0xFFFF
            port.write(who(self._sequence))
            self.pause()
            for body in self._bodies():
                found = identity(body)
                if found is not None and self._answers(found.sequence):
                    return found
        raise DeviceError(f"no force sensor answers at {self.address.place}")

    def ask(self) -> None:
        self._sequence = (self._sequence + 1) & 0xFFFF
        self._opened().write(ask(self._sequence))

    def receive(self) -> Heard:
        answers = [found for body in self._bodies() if (found := answer(body))]
        if not answers:
            return SILENT
        *earlier, newest = map(self._heard, answers)
        return replace(newest, earlier=tuple(earlier))

    def _heard(self, one: Answer) -> Heard:
        # Older, a second time, or to nobody's question, it is no new sample.
        in_time = self._answers(one.sequence)
        if in_time:
            self._answered = one.sequence
        return Heard(
            counts=one.counts if in_time else None,
            clipped=one.clipped,
            device_time=self._clock.seconds(one.microseconds),
            error=self._wrong(one),
        )

    def _answers(self, sequence: int) -> bool:
        """Whether an answer is to one of the last questions, and the first one to it."""
        lag = (self._sequence - sequence) & 0xFFFF
        return lag <= LONGEST_LAG and lag < (self._sequence - self._answered) & 0xFFFF

    def _wrong(self, one: Answer) -> DeviceError | None:
        if one.status & AnswerFlag.BROWN_OUT:
            return BoardError("the board reports a brown-out: its bridges had too little voltage")
        if one.status:
            return BoardError(f"the board reports {one.status!r}")
        if len(one.counts) != len(self.file.channels):
            return ProtocolError(
                f"{len(one.counts)} channels came of a sensor that has {len(self.file.channels)}"
            )
        absent = [index + 1 for index in one.clipped if index >= len(one.counts)]
        if absent:
            return ProtocolError(
                f"the board says that channel {min(absent)} is at the end of its range, and it has "
                f"{len(one.counts)}"
            )
        return None

    def _bodies(self) -> list[bytes]:
        port = self._opened()
        port.exchange_done()
        return self._splitter.feed(port.read())

    def serial(self) -> str | None:
        return None if self._identity is None else str(self._identity.serial)

    def close(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None

    def _opened(self) -> SerialPort:
        assert self._port is not None, "configure comes first"
        return self._port
