"""What a driver is: the facts that its class declares, and the calls that it answers with values.

A driver speaks one protocol. It is handed to a ``Device``, which judges what came, limits what goes
out, and alone knows of states, faults and permissions; a driver knows none of them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from cosim.base.errors import InputError
from cosim.base.system.pulse import Pulse
from hil.device.board.driver import BoardDriver
from hil.device.contract import ZERO, BusUse, Received, Watchdog
from hil.safety.linkage import Pair
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.setup.registry import GROUP, find

if TYPE_CHECKING:
    from hil.wire.serial_port import SerialPort


class Driver(BoardDriver, ABC):
    """One protocol on one port; registered under the entry points ``cohaptic.devices``.

    ``parameters`` are the scenario's, for what only a simulated device can use. Every call but
    ``open`` is bounded in time; errors are raised as ``DeviceError``.
    """

    def __init__(
        self,
        address: DeviceAddress,
        file: DeviceFile,
        *,
        tick: Fraction = Fraction(1, 1024),
        pulse: Pulse | None = None,
        number: int = 0,
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        super().__init__(address, tick=tick, pulse=pulse, number=number)
        self.file = file
        self.parameters = dict(parameters or {})

    @classmethod
    def bus_use(cls, address: DeviceAddress, file: DeviceFile) -> BusUse | None:
        """The frames of one tick that ``cohaptic check`` counts; ``None`` off a CAN bus."""
        del address, file
        return None

    @property
    def watchdog(self) -> Watchdog:
        """What the board does by itself when the host falls silent."""
        return Watchdog()

    watchdog_seen: float | None = None
    """Timeout (s) of the watchdog that was seen to fire since the port was opened."""

    def watchdog_proved(self, timeout: float) -> bool:
        """Whether a watchdog with this timeout (s) was seen to fire on this device.

        At this opening; or, for what is done without force, as the device file has it. For drivers
        whose boards tell nothing that could be read back.
        """
        if self.watchdog_seen is not None:
            return abs(self.watchdog_seen - timeout) < 1e-6
        proof = self.file.watchdog_proof
        return (
            proof is not None
            and abs(proof.timeout - timeout) < 1e-6
            and proof.serial == self.file.serial
        )

    @property
    def port(self) -> SerialPort | None:
        """The serial line that it speaks on; ``None`` on a bus, or behind a maker's library."""
        return None

    @property
    def knows_its_pose(self) -> bool:
        """Whether it measures absolute angles, so that it needs no pose to be homed in."""
        return False

    # --- what a protocol does --------------------------------------------------------------------

    @abstractmethod
    def open(self) -> None:
        """Open and set up; on return the device answers and its torque is zero."""

    @abstractmethod
    def receive(self) -> Received:
        """What has come since the last call, and what it says of the board."""

    def silence(self) -> str | None:
        """What is known of why nothing comes, as a part of a sentence."""
        return None

    @abstractmethod
    def send(self, torque: Pair) -> Pair | None:
        """Send joint torques (N.m); returns them computed back, ``None`` where none went out."""

    @abstractmethod
    def send_zero(self) -> bool:
        """Command zero; whether that went out, or is known to be there. An answer confirms it."""

    def feed(self) -> None:
        """Zero torque, and all that keeps the board's watchdog from firing from now on."""
        self.send(ZERO)

    @abstractmethod
    def close(self) -> None:
        """Let go of the port; safe when it was never opened."""

    def set_home(self, home: Pair) -> None:
        """Tell the device its joint angles (rad), where it wants to know them."""

    def enter(self) -> None:
        """Enter closed loop at zero torque."""

    def leave(self) -> None:
        """Leave closed loop."""

    def take_over(self) -> None:
        """Forget what was true in the process that died (answers that it had asked for)."""

    def recover(self) -> None:
        """Complete or drain a frame that a dead loop left half written."""


def find_driver(name: str) -> type[Driver]:
    """A registered driver's class.

    Raises:
        InputError: there is no driver of that name, or what is registered is none.
    """
    kind = find(name)
    if kind.measures_only:
        raise InputError(
            f"'{name}' is a sensor, which measures and pushes nothing: there is nothing to home, "
            "to calibrate the signs of, or to allow; see 'cohaptic device check'"
        )
    if not issubclass(kind, Driver):
        raise InputError(
            f"the entry point '{name}' of {GROUP} is no subclass of hil.device.driver.Driver"
        )
    return kind
