"""``haply:///dev/ttyACM0``: Haply 2DIY boards and their relatives that speak hAPI over USB.

The board answers a torque with its angles, so what is read at a tick was sampled when the previous
torque arrived: one tick of latency. It has no watchdog and its protocol no checksum. So a frame is
never sent while an answer is outstanding, any odd byte is a fault, and a fault needs a new homing.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import degrees, radians
from typing import Annotated, ClassVar

from pydantic import Field

from cosim.base.document.form import QuantityIn
from cosim.base.errors import InputError
from hil.device.contract import NOTHING, ZERO, Received, Sample
from hil.device.driver import Driver
from hil.device.errors import ProtocolError
from hil.drivers.haply.preset import HAPLY
from hil.drivers.haply.protocol import (
    IO_BYTES,
    REPLY_BYTES,
    HaplyAxis,
    angles,
    reset,
    setup,
    torques,
)
from hil.safety.conversion import TorqueDrive
from hil.safety.linkage import Pair
from hil.setup.driver_facts import DriverSettings
from hil.setup.options import IntegersIn, read_options
from hil.setup.preset import Preset
from hil.wire.serial_port import SerialOptions, SerialPort

DEVICE = 5
"""The board's address that the maker's examples use."""
OUTSTANDING_TICKS = 3
"""Ticks without an answer after which the board is taken to be out of step."""
IDLE_TICKS = 8
"""The same where zero was asked for: nothing pushes, so a hiccup of the host may pass."""
RECOVERY_TICKS = 2
"""The same after a set-up in recovery: then the other parity is tried."""
ANSWER_SECONDS = 0.020


Ports = Annotated[
    tuple[int, ...], IntegersIn(least=1, most=4, what="two different ports of 1 to 4, such as 2,1")
]


class HaplyOptions(SerialOptions):
    """Options in a Haply's URL."""

    ports: Ports | None = Field(default=None, description="The ports of the two motors.")


class HaplySettings(DriverSettings):
    """``settings`` in a Haply's device file."""

    ports: Ports = Field(default=(2, 1), description="The ports of the two motors.")
    rotation: Annotated[
        tuple[int, ...],
        IntegersIn(least=0, most=1, what="two of 0 or 1, such as 1,1", different=False),
    ] = Field(default=(1, 1), description="Which way each encoder counts.")
    device: Annotated[
        int, QuantityIn(unit="1", what="device number from 0 to 255", least=0, most=255, whole=True)
    ] = Field(default=DEVICE, description="The board's number.")


class HaplyDriver(Driver):
    """Two axes on a serial port."""

    driver = "haply"
    settings = HaplySettings
    options = HaplyOptions
    latency_ticks: ClassVar[int] = 1
    emulator = "hil.drivers.haply.emulator:make"
    presets: ClassVar[Mapping[str, Preset]] = {"haply": HAPLY}
    preset = "haply"
    found_on = "serial"
    checks_frames: ClassVar[bool] = False

    _port: SerialPort | None = None

    @property
    def port(self) -> SerialPort | None:
        return self._port

    def open(self) -> None:
        given = self.file.settings_of(HaplySettings)
        ports = read_options(HaplyOptions, self.address).ports or given.ports
        rotation = given.rotation
        self._number = given.device
        self._axes = [
            HaplyAxis(
                port=ports[i], rotation=int(rotation[i]), counts_per_turn=joint.counts_per_turn
            )
            for i, joint in enumerate(self.file.joints)
        ]
        self._port = SerialPort(self.address, self.pulse, self.number)
        self._set_up(ZERO)
        self._exchange_zero()

    def set_home(self, home: Pair) -> None:
        """Preset the counts: the shaft stands at the home pose now."""
        shaft = [
            joint.direction * (angle - joint.offset)
            for joint, angle in zip(self.file.joints, home, strict=True)
        ]
        self._set_up((shaft[0], shaft[1]))

    def _set_up(self, shaft: Pair) -> None:
        axes = [
            HaplyAxis(
                port=axis.port,
                rotation=axis.rotation,
                offset=degrees(angle),
                counts_per_turn=axis.counts_per_turn,
            )
            for axis, angle in zip(self._axes, shaft, strict=True)
        ]
        port = self._opened()
        port.read()
        port.write(reset(self._number) + setup(self._number, axes))
        port.read()
        self._outstanding, self._zero_asked, self._sequence = 0, False, 0
        self._reply = b""
        self._recovering: int | None = None
        self._tries, self._in_step = 0, False
        """Set-ups in recovery that no answer has followed yet; whether one has followed since."""

    def _exchange_zero(self) -> None:
        """The first answer, waited for."""
        self.send_zero()
        reply = self._opened().wait(REPLY_BYTES, ANSWER_SECONDS)
        if not reply:
            raise ProtocolError(f"no Haply answers at {self.address.place}")
        angles(self._number, self._axes, reply)
        self._outstanding = 0

    def receive(self) -> Received:
        port = self._opened()
        port.exchange_done()
        self._reply += port.read(REPLY_BYTES * 4)
        if self._recovering is not None:
            self._align()
            return NOTHING
        if self._outstanding and len(self._reply) < REPLY_BYTES:
            self._outstanding += 1
            longest = IDLE_TICKS if self._zero_asked else OUTSTANDING_TICKS
            if self._tries and self._outstanding > RECOVERY_TICKS:
                self._try_again()
            elif self._outstanding > longest:
                raise self._out_of_step(f"no whole answer for {longest} ticks")
            return NOTHING
        if not self._reply:
            return NOTHING
        if not self._outstanding or len(self._reply) > REPLY_BYTES:
            raise self._odd_answer("bytes came that nobody asked for")
        try:
            found = angles(self._number, self._axes, self._reply)
        except ProtocolError as error:
            raise self._odd_answer(str(error)) from None
        if self._tries and not self._in_step:
            self._set_up_once_more()
            return NOTHING
        self._reply = b""
        self._outstanding = self._tries = 0
        self._sequence += 1
        first, second = (
            round(angle / 360.0 * axis.counts_per_turn)
            for angle, axis in zip(found, self._axes, strict=True)
        )
        sample = Sample(
            shaft_angle=(radians(found[0]), radians(found[1])),
            count=(first, second),
            sequence=self._sequence,
        )
        # One answer is outstanding at most, so this one is to the last torque.
        return Received(sample=sample, zero_confirmed=self._zero_asked)

    def _out_of_step(self, what: str) -> ProtocolError:
        self._recovering, self._reply = 0, b""
        return ProtocolError(f"{what}: host and board are out of step")

    def _odd_answer(self, what: str) -> ProtocolError:
        """A board that answers has just finished a frame, so it can be set up and zeroed at once.

        Should it wait for the rest of a frame all the same, its silence is noticed like any other.
        """
        fault = self._out_of_step(what)
        self._set_up(ZERO)
        self._tries = 1
        return fault

    def _align(self) -> None:
        """An answer while aligning means that the board has just finished a frame."""
        if len(self._reply) >= REPLY_BYTES or self._recovering == IO_BYTES:
            self._set_up(ZERO)
            self._tries = 1

    def _set_up_once_more(self) -> None:
        """A set-up that was misread may leave a board with one motor that answers all the same.

        Having answered, it has finished a frame: it reads this one as it is meant.
        """
        self._set_up(ZERO)
        self._tries, self._in_step = 1, True

    def _try_again(self) -> None:
        """A board that took the last zero byte for the first one of a reset: one byte more.

        The next time two, and so on, because what is misread may shift the parity itself.
        """
        tries = self._tries + 1
        self._opened().write(bytes(self._tries))
        self._set_up(ZERO)
        self._tries = tries

    def send(self, torque: Pair) -> Pair | None:
        if self._outstanding or self._recovering is not None:
            return None
        drives = [_drive(joint.drive) for joint in self.file.joints]
        codes = (drives[0].encode(torque[0]), drives[1].encode(torque[1]))
        self._zero_asked = codes == ZERO
        self._opened().write(torques(self._number, self._axes, codes))
        self._outstanding = 1
        return drives[0].decode(codes[0]), drives[1].decode(codes[1])

    def send_zero(self) -> bool:
        """Zero; after an odd answer one byte a tick first, until both sides are aligned again.

        Zero bytes complete a torque frame that the board may be waiting for with torques of
        (almost) zero, because the exponent of a little-endian float comes last; the answer to it
        tells that both sides are aligned. Where no frame was open, they are harmless resets.
        """
        if self._recovering is None:
            return self.send(ZERO) is not None
        self._opened().write(b"\0")
        self._recovering += 1
        return False

    def take_over(self) -> None:
        self._outstanding, self._recovering, self._reply = 0, None, b""
        self._opened().take_over()

    def recover(self) -> None:
        self._recovering, self._reply = 0, b""

    def close(self) -> None:
        if self._port is not None:
            self._port.close()
            self._port = None

    def _opened(self) -> SerialPort:
        assert self._port is not None, "configure comes first"
        return self._port


def _drive(drive: object) -> TorqueDrive:
    if not isinstance(drive, TorqueDrive):
        raise InputError("a Haply takes torque: its 'drive' has a gear and a direction only")
    return drive
