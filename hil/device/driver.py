"""What a driver is: the facts that it declares and the hooks that it fills in.

The rest of a device (``fault_latch``, ``measuring``, ``lifecycle``, ``device``) is built on these
hooks and is final: a driver that replaces any of it is refused when its class is made. So no torque
reaches a hook without the safety layer, and every error becomes FAULT.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from fractions import Fraction
from typing import Any, ClassVar

from cosim.base.pulse import Pulse
from hil.device.contract import ZERO, BusUse, Sample, Watchdog
from hil.safety.linkage import Pair
from hil.safety.permission import Permission
from hil.setup.address import Address
from hil.setup.device_file import DeviceFile
from hil.setup.options import UrlOptions
from hil.setup.settings import DriverSettings


class Driver(ABC):
    """The part of a device that belongs to its driver; derive from ``hil.device.device.Device``.

    ``tick`` is the control period (s). ``permission`` lets torque out; without one the output is
    dry. ``pulse`` is the supervisor's shared memory, ``None`` without a supervisor. ``clock``
    gives host seconds for the lateness rule; ``None`` (lock-step) counts ticks instead.
    """

    driver: ClassVar[str]
    latency_ticks: ClassVar[int] = 0
    """Ticks from a torque to the first sample that can show its effect, beyond the FMU's."""
    native_period_ticks: ClassVar[float] = 1.0
    """How often the device has a new sample, in control ticks."""
    in_process: ClassVar[bool] = False
    """Whether there is no hardware and no other process behind it (``mock``)."""
    shares_port: ClassVar[bool] = True
    """Whether a supervisor can open it and hand it to the loop; a maker's library cannot."""
    tested_on_hardware: ClassVar[bool] = False
    has_input: ClassVar[bool] = False
    """Whether the board tells of a switch on it, which can serve as a dead-man input."""

    settings: ClassVar[type[DriverSettings]] = DriverSettings
    """The form of ``settings`` in its device file."""
    options: ClassVar[type[UrlOptions]] = UrlOptions
    """The form of the options in its URL."""

    def __init_subclass__(cls, **keywords: Any) -> None:
        super().__init_subclass__(**keywords)
        replaced = sorted(name for name in vars(cls) if _is_final(cls, name))
        if replaced:
            message = f"{cls.__name__} replaces {', '.join(replaced)}: drivers fill in hooks only"
            raise TypeError(message)

    def __init__(
        self,
        address: Address,
        file: DeviceFile,
        *,
        tick: Fraction = Fraction(1, 1024),
        permission: Permission | None = None,
        pulse: Pulse | None = None,
        clock: Callable[[], float] | None = None,
    ) -> None:
        self.address = address
        self.file = file
        self.tick = float(tick)
        self.permission = permission
        self.pulse = pulse
        self.name = address.url
        self.number = 0
        """Which device of the run it is, for the supervisor."""
        self.parameters: dict[str, Any] = {}
        """The scenario's pantograph parameters, for what only a simulated device can use."""
        self.zeros_confirmed = 0
        """Answers so far that confirm a torque of zero; hooks count them."""
        self.watchdog_reports = 0
        """Answers so far that say that the board's watchdog has fired; hooks count them."""
        self.input_held = False
        """Whether that switch was closed in the newest answer; hooks set it."""
        self._clock = clock

    @classmethod
    def bus_use(cls, address: Address, file: DeviceFile) -> BusUse | None:
        """The frames of one tick that ``cohaptic check`` counts; ``None`` off a CAN bus."""
        del address, file
        return None

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

    # --- hooks -----------------------------------------------------------------------------------

    @abstractmethod
    def _open(self) -> None:
        """Open and set up; on return the device answers and its torque is zero."""

    @abstractmethod
    def _receive(self) -> Sample | None:
        """The newest valid sample since the last call, or ``None``; bounded in time."""

    @abstractmethod
    def _send(self, tick: int, torque: Pair) -> Pair | None:
        """Send joint torques (N.m); returns them computed back, ``None`` where none went out."""

    @abstractmethod
    def _close(self) -> None:
        """Let go of the port; safe when it was never opened."""

    def _send_zero(self) -> None:
        """Command zero; ``zeros_confirmed`` counts the answers that confirm one."""
        self._send(0, ZERO)

    def _serial(self) -> str | None:
        """The connected device's serial number, ``None`` where it has none to tell."""
        return None

    def _preset(self, home: Pair) -> None:
        """Tell the device its joint angles (rad), where it wants to know them."""

    def _enter(self) -> None:
        """Enter closed loop at zero torque."""

    def _leave(self) -> None:
        """Leave closed loop."""

    def _take_over(self) -> None:
        """Forget what was true in the process that died (answers that it had asked for)."""

    def _recover(self) -> None:
        """Complete or drain a frame that a dead loop left half written."""


def _is_final(kind: type, name: str) -> bool:
    """Whether a base of ``kind`` marked ``name`` with ``typing.final``."""
    for base in kind.__mro__[1:]:
        found = vars(base).get(name)
        inner = (getattr(found, wrapper, None) for wrapper in ("__func__", "fget", "func"))
        method = next((wrapped for wrapped in inner if wrapped is not None), found)
        if getattr(method, "__final__", False):
            return True
    return False
