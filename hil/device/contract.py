"""The values that a device, its driver and the rest of cohaptic exchange every tick."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag, StrEnum

from hil.device.errors import DeviceError
from hil.safety.linkage import Pair

ZERO: Pair = (0.0, 0.0)


class State(StrEnum):
    """Where a device is in its life; FAULT is left by ``reset`` alone."""

    UNCONFIGURED = "unconfigured"
    INACTIVE = "inactive"
    ACTIVE = "active"
    FAULT = "fault"


class Status(IntFlag):
    """The bits of the pantograph's ``status`` output."""

    HOMED = 1
    ACTIVE = 2
    FAULT = 4
    OUTPUT_ENABLED = 8


class Flag(IntFlag):
    """What the safety layer did to a command, and what else is worth recording of a tick."""

    NONE = 0
    NOT_A_NUMBER = 1
    AGED = 2
    TORQUE_LIMIT = 4
    HEAT_LIMIT = 8
    SLEW_LIMIT = 16
    SPEED_LIMIT = 32
    OUTSIDE_WORKSPACE = 64
    RAMPING = 128
    DRY = 256
    NOT_SENT = 512
    IGNORED_INPUT = 1024
    NEAR_BORDER = 2048
    ZEROING = 4096
    """Zero is on the wire; what is told as sent was before it, until an answer confirms zero."""


class WriteOutcome(StrEnum):
    """What is known of the motors after a fault."""

    PENDING = "pending"
    ZERO_CONFIRMED = "zero confirmed"
    WATCHDOG = "board watchdog"
    UNKNOWN = "output unknown"


CUT_POWER = "cut the power: the device may still be pushing"


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """What a driver received: shaft angles (rad) at the device's own zero, and raw counts."""

    shaft_angle: Pair
    count: tuple[int, int]
    sequence: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Received:
    """What ``Driver.receive`` returns: the newest valid sample, and what the board says of itself.

    Every field is judged by the device; a driver only reports.
    """

    sample: Sample | None = None
    zero_confirmed: bool = False
    """An answer says that the torque is zero, and nothing but zero was sent since it was asked."""
    watchdog_fired: bool = False
    enabled: bool | None = None
    """Whether the output stage is on; ``None`` where nothing came that tells."""
    contradiction: str | None = None
    """What the board says of its output that is not what it was told, as a sentence; empty where
    both agree, ``None`` where nothing came that tells."""
    input_held: bool | None = None
    """Whether the switch on the board is closed; ``None`` where nothing came that tells."""
    device_time: float | None = None
    """The board's own clock (s) as the sample was taken, where it has one."""
    error: DeviceError | None = None
    """What is wrong with the board or its bus, where something is."""
    earlier: tuple[Received, ...] = ()
    """What came before it in the same tick, the oldest first: judged, and no new sample."""

    @property
    def each(self) -> tuple[Received, ...]:
        """All that came in the tick, the oldest first."""
        return (*self.earlier, self)


NOTHING = Received()


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """What ``Device.read`` returns: calibrated joint angles (rad) and how old they are (ticks)."""

    joint_angle: Pair
    count: tuple[int, int]
    sequence: int
    sample_age: int
    status: Status
    device_time: float | None
    host_time: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Sent:
    """What ``Device.write`` returns.

    ``torque`` (N.m) is computed back from the code that was last put on the wire: commanded, not
    measured. When the motors are brought to zero it stays until an answer confirms that.
    ``limited`` is what the safety layer allowed; with dry output it differs from ``torque``.
    """

    torque: Pair
    limited: Pair
    flags: Flag


LONGEST_WATCHDOG = 0.1
"""A board that lets its host be silent for longer (s) has no watchdog worth the name."""


@dataclass(frozen=True, slots=True)
class Watchdog:
    """Whether a board drops its torque by itself when the host falls silent.

    ``timeout`` (s) is ``None`` where there is no watchdog; ``verified`` says that it was configured
    and read back, or proved, on this very device.
    """

    timeout: float | None = None
    verified: bool = False

    @property
    def protects(self) -> bool:
        """Whether it may be relied on."""
        return self.verified and self.timeout is not None and self.timeout <= LONGEST_WATCHDOG


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchdogProof:
    """When a board's watchdog was seen to fire, with what ``timeout`` and how fast (s)."""

    date: str
    timeout: float
    fired_after: float
    serial: str | None = None


@dataclass(frozen=True, slots=True)
class BusUse:
    """Data bytes of each frame that a device has on its CAN bus in one tick.

    ``shared`` frames are sent once for all devices of the bus (SYNC).
    """

    frames: tuple[int, ...]
    shared: tuple[int, ...] = ()
    nodes: tuple[int, ...] = ()
    """Those that it has to itself."""
