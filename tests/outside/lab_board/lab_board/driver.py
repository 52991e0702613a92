"""``lab:///dev/ttyACM0``: our board, which speaks lines of text.

It answers each command, so what is read at a tick is a tick old. It drops its torque by itself
after 20 ms of silence.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import isfinite
from typing import Annotated, ClassVar

from pydantic import Field

from cosim.base.document.form import QuantityIn
from hil.device.contract import NOTHING, Received, Watchdog
from hil.device.driver import Driver
from hil.device.errors import DeviceError
from hil.drivers.samples import sample_of_counts
from hil.safety.linkage import Linkage, Pair
from hil.setup.driver_facts import DriverSettings
from hil.setup.preset import Motor, Preset
from hil.wire.serial_port import SerialOptions, SerialPort
from lab_board import protocol as wire

WATCHDOG = 0.020
TRIES = 50
OLDEST = 2

LAB = Preset(
    linkage=Linkage(proximal=0.08, distal=0.12, base=0.05),
    counts_per_turn=16384,
    motor=Motor(peak_torque=0.2, continuous_torque=0.1),
    limits={"torque": 0.1},
    rest=(0.025, 0.14),
    model={"proximal_length": 0.08, "distal_length": 0.12, "base_distance": 0.05},
)


class LabSettings(DriverSettings):
    """``settings`` in the device file of our board."""

    full_scale: Annotated[
        float, QuantityIn(unit="N.m", what="torque, such as 0.2", above=0, most=1)
    ] = Field(default=0.2, description="No more than this is ever sent (N.m).")


class LabDriver(Driver):
    """Two axes that take torque and answer with counts."""

    driver = "lab"
    settings = LabSettings
    options = SerialOptions
    latency_ticks: ClassVar[int] = 1
    emulator = "lab_board.emulator:make"
    presets: ClassVar[Mapping[str, Preset]] = {"lab": LAB}
    preset = "lab"
    command_unit = "N.m"
    found_on = "serial"
    usb_ids = ((0x1209, 0x0001),)

    _port: SerialPort | None = None

    @property
    def watchdog(self) -> Watchdog:
        """Verified at each opening that is to have force: it is seen to fire."""
        return Watchdog(timeout=WATCHDOG, verified=self.watchdog_proved(WATCHDOG))

    @property
    def port(self) -> SerialPort | None:
        """The line, for those who try it with damaged commands."""
        return self._port

    def open(self) -> None:
        """The board answers, and its output stage is off."""
        self._port = SerialPort(self.address, self.pulse, self.number)
        self._lines, self._sequence, self._hot, self._seen = wire.Lines(), 0, 0, 0
        for _ in range(TRIES):
            self.send_zero()
            self.pause()
            if self.receive().sample is not None:
                return
        raise DeviceError(f"no board answers at {self.address.place}")

    def receive(self) -> Received:
        """Every valid answer that came, and what it says; the newest one measures."""
        port = self._opened()
        port.exchange_done()
        answers = [found for data in self._lines.feed(port.read()) if (found := wire.answer(data))]
        if not answers:
            return NOTHING
        *earlier, newest = map(self._told, answers)
        return replace(newest, earlier=tuple(earlier))

    def _told(self, one: wire.Answer) -> Received:
        sample = None
        if 0 <= self._sequence - one.sequence <= OLDEST:
            self._seen += 1
            sample = sample_of_counts(self.file.joints, one.count, self._seen)
        return Received(
            sample=sample,
            # Only an answer to what was sent after the last torque speaks of a zero since.
            zero_confirmed=bool(one.status & wire.ZERO) and one.sequence > self._hot,
            watchdog_fired=bool(one.status & wire.FIRED),
            enabled=bool(one.status & wire.ENABLED),
        )

    def send(self, torque: Pair) -> Pair:
        """Torques in whole micronewton metres, rounded toward zero."""
        scale = self.file.settings_of(LabSettings).full_scale
        codes: list[int] = []
        given: list[float] = []
        for joint, wanted in zip(self.file.joints, torque, strict=True):
            if not isfinite(wanted):
                raise ValueError(f"{wanted} is no torque")
            code = int(min(max(joint.drive.encode(wanted), -scale), scale) * 1e6)
            codes.append(code)
            given.append(joint.drive.decode(code * 1e-6))
        self._put(wire.TORQUE, *codes)
        if codes != [0, 0]:
            self._hot = self._sequence
        return given[0], given[1]

    def send_zero(self) -> bool:
        """Zero, and the output stage off."""
        self._put(wire.OFF, 0, 0)
        return True

    def enter(self) -> None:
        """The output stage on, at zero."""
        self._put(wire.CLEAR, 0, 0)

    def take_over(self) -> None:
        """In another process: forget what was half read."""
        self._opened().take_over()
        self._lines = wire.Lines()

    def recover(self) -> None:
        """End a line that was half sent."""
        self._opened().write(b"\n")

    def close(self) -> None:
        """Let go of the port."""
        if self._port is not None:
            self._port.close()
            self._port = None

    def _put(self, kind: str, *codes: int) -> None:
        self._sequence += 1
        self._opened().write(wire.line(kind, self._sequence, *codes))

    def _opened(self) -> SerialPort:
        assert self._port is not None, "open comes first"
        return self._port
