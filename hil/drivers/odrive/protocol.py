"""ODrive's CAN Simple protocol: identifier = node << 5 | command, little-endian.

Source: ODrive's published CAN documentation (message table, firmware 0.5 and 0.6).
"""

from __future__ import annotations

import struct
from enum import IntEnum

from hil.device.errors import ProtocolError


class OdriveCommand(IntEnum):
    """The commands used here."""

    HEARTBEAT = 0x01
    ESTOP = 0x02
    WRITE_ENDPOINT = 0x04
    READ_ENDPOINT = 0x05
    SET_STATE = 0x07
    ESTIMATES = 0x09
    SET_MODES = 0x0B
    SET_TORQUE = 0x0E
    SET_LIMITS = 0x0F
    CLEAR_ERRORS = 0x18


IDLE, CLOSED_LOOP = 1, 8
_STATES = {
    0: "undefined",
    IDLE: "idle",
    2: "in its start-up sequence",
    3: "calibrating",
    CLOSED_LOOP: "in closed loop",
}
TORQUE_CONTROL, PASSTHROUGH = 1, 1
WATCHDOG_EXPIRED = {"0.5": 0x800, "0.6": 0x01000000}
"""The error bit of an expired watchdog, by firmware; 0x800 is a brake's current in 0.6."""
DEVICE_COMMANDS = frozenset(
    {OdriveCommand.HEARTBEAT, OdriveCommand.ESTIMATES, OdriveCommand.READ_ENDPOINT}
)
"""What an axis sends; everything else comes from the host."""


def identifier(node: int, command: OdriveCommand) -> int:
    """The CAN identifier of a command to, or from, a node (0 to 63)."""
    return node << 5 | command


def state_name(state: int) -> str:
    """An axis state in words."""
    return _STATES.get(state, f"in state {state}")


def set_state(state: int) -> bytes:
    """Requested axis state."""
    return struct.pack("<I", state)


def set_modes(control: int = TORQUE_CONTROL, source: int = PASSTHROUGH) -> bytes:
    """Controller and input mode."""
    return struct.pack("<II", control, source)


def set_limits(velocity: float, current: float) -> bytes:
    """Velocity (turns/s) and current (A) limits."""
    return struct.pack("<ff", velocity, current)


def set_torque(torque: float) -> bytes:
    """Motor torque (N.m)."""
    return struct.pack("<f", torque)


def write_endpoint(endpoint: int, value: float | bool) -> bytes:
    """Write a configuration value by its endpoint number (firmware 0.6)."""
    head = struct.pack("<BHB", 1, endpoint, 0)
    return head + (
        struct.pack("<?", value) if isinstance(value, bool) else struct.pack("<f", value)
    )


def heartbeat(data: bytes) -> tuple[int, int]:
    """(error bits, axis state).

    Raises:
        ProtocolError: it is not 8 bytes.
    """
    if len(data) != 8:
        raise ProtocolError(f"an ODrive heartbeat has 8 bytes, {len(data)} came")
    error, state = struct.unpack_from("<IB", data)
    return error, state


def estimates(data: bytes) -> tuple[float, float]:
    """Encoder position (turns) and velocity (turns/s).

    Raises:
        ProtocolError: it is not 8 bytes, or holds something that is no number.
    """
    if len(data) != 8:
        raise ProtocolError(f"ODrive encoder estimates have 8 bytes, {len(data)} came")
    position, velocity = struct.unpack("<ff", data)
    if not (abs(position) < 1e6 and abs(velocity) < 1e6):
        raise ProtocolError("ODrive encoder estimates that are no numbers")
    return position, velocity
