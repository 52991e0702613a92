"""What a driver is: the facts that its class declares, and the calls that it answers with values.

A driver speaks one protocol. It is handed to a ``Device``, which judges what came, limits what goes
out, and alone knows of states, faults and permissions; a driver knows none of them.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, ClassVar

from cosim.base.system.pulse import Pulse
from hil.device.contract import ZERO, BusUse, Received, Watchdog
from hil.safety.linkage import Pair
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.setup.options import UrlOptions
from hil.setup.settings import DriverSettings


class Driver(ABC):
    """One protocol on one port; registered under the entry points ``cohaptic.devices``.

    ``tick`` is the control period (s). ``pulse`` is the supervisor's shared memory, ``None``
    without a supervisor, where the device is number ``number``. ``parameters`` are the scenario's,
    for what only a simulated device can use. Every call but ``open`` and ``preset`` is bounded in
    time; errors are raised as ``DeviceError``.
    """

    driver: ClassVar[str]
    """Its name, as in a URL."""
    latency_ticks: ClassVar[int] = 0
    """Ticks from a torque to the first sample that can show its effect, beyond the FMU's."""
    native_period_ticks: ClassVar[float] = 1.0
    """How often the device has a new sample, in control ticks."""
    in_process: ClassVar[bool] = False
    """Whether there is no hardware and no other process behind it (``mock``)."""
    shares_port: ClassVar[bool] = True
    """Whether another process can go on with its open port; with a maker's library none can."""
    tested_on_hardware: ClassVar[bool] = False
    has_input: ClassVar[bool] = False
    """Whether the board tells of a switch on it, which can serve as a dead-man input."""
    settings: ClassVar[type[DriverSettings]] = DriverSettings
    """The form of ``settings`` in its device file."""
    options: ClassVar[type[UrlOptions]] = UrlOptions
    """The form of the options in its URL."""
    emulator: ClassVar[str | None] = None
    """``module:function`` that makes its emulated board (``hil.emulation.launch``)."""
    preset: ClassVar[str] = "quanser"
    """The device that a device file describes where it does not name one."""
    takes_volts: ClassVar[bool] = False
    """Whether it takes volts: then a drive defaults to the preset's motor and amplifier."""
    found_on: ClassVar[str | None] = None
    """Where ``cohaptic device find`` looks for it: ``serial``, ``can``, or nowhere."""
    usb_ids: ClassVar[tuple[tuple[int, int], ...]] = ()
    """Vendor and product numbers of boards that are known to be this one's."""

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
        self.address = address
        self.file = file
        self.tick = float(tick)
        self.pulse = pulse
        self.number = number
        self.parameters = dict(parameters or {})

    @classmethod
    def component(cls, url: str, options: dict[str, Any], safety: dict[str, Any]) -> Any:
        """The component that a scenario's ``device: URL`` stands for (entry point contract).

        ``safety`` are limits that the scenario puts on every device: the tighter ones hold.
        """
        from hil.device.component import DeviceComponent  # it needs this class itself

        return DeviceComponent(cls, url, options, safety)

    @classmethod
    def bus_use(cls, address: DeviceAddress, file: DeviceFile) -> BusUse | None:
        """The frames of one tick that ``cohaptic check`` counts; ``None`` off a CAN bus."""
        del address, file
        return None

    @property
    def name(self) -> str:
        """What sentences call the device."""
        return self.address.url

    @property
    def watchdog(self) -> Watchdog:
        """What the board does by itself when the host falls silent."""
        return Watchdog()

    def watchdog_proved(self, timeout: float) -> bool:
        """Whether the device file says that a watchdog with this timeout (s) fired on this device.

        For drivers whose boards tell nothing that could be read back.
        """
        proof = self.file.watchdog_proof
        return (
            proof is not None
            and abs(proof.timeout - timeout) < 1e-6
            and proof.serial == self.file.serial
        )

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.address.is_lockstep

    def pause(self) -> None:
        """One tick's time between exchanges outside the loop; none where no clock is involved."""
        if self.pulse is not None:
            self.pulse.beat()
        if not (self.in_process or self.lockstep):
            time.sleep(self.tick)

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

    def serial(self) -> str | None:
        """The connected device's serial number, ``None`` where it has none to tell."""
        return None

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
