"""CiA 402 in process data: controlword and target out, statusword, position and demand back.

Sources: CiA 402-2 (drives and motion control), CiA 301 (communication).
"""

from __future__ import annotations

import struct
from enum import IntEnum

from hil.device.errors import ProtocolError

ABORT_CONNECTION, DISABLE_VOLTAGE = 0x6007, 2
"""What a drive does once its host is lost, and the value that takes its torque off."""
CONTROL, STATUS = 0x6040, 0x6041
MODE, MODE_SHOWN, MODES = 0x6060, 0x6061, 0x6502
POSITION = 0x6064
TARGET, DEMAND, RATED = 0x6071, 0x6074, 0x6076
"""In thousandths of the rated torque, which is in mN.m."""
SLOPE, FASTEST = 0x6087, 10_000_000
"""How fast mode 4 lets the torque change, in thousandths a second: from end to end in a tick."""
ENCODER, ENCODER_TURNS = 1, 2
"""Sub-indices of 608Fh: increments in so many turns."""
RESOLUTION = 0x608F
PROFILE_TORQUE, CYCLIC_TORQUE = 4, 10
TORQUE_OFF = {
    0x605A: "quick stop",
    0x605B: "shutdown",
    0x605C: "disable operation",
    0x605D: "halt",
    0x605E: "fault reaction",
}
"""Option codes: at 0 the drive takes its torque off; every other value brakes, or holds."""
HALT = 0x605D
"""Never asked for by us, and not in every drive."""


class Controlword(IntEnum):
    """Controlwords."""

    VOLTAGE_OFF = 0x00
    SHUTDOWN = 0x06
    SWITCH_ON = 0x07
    ENABLE = 0x0F
    RESET_FAULT = 0x80
    """Its rising edge."""


class DriveState(IntEnum):
    """States of a drive, as a statusword masked by 6Fh (4Fh) shows them."""

    NOT_READY = 0x00
    DISABLED = 0x40
    READY = 0x21
    SWITCHED_ON = 0x23
    ENABLED = 0x27
    QUICK_STOP = 0x07
    FAULT_REACTION = 0x0F
    FAULT = 0x08

    @property
    def words(self) -> str:
        """Its name in a sentence."""
        return {
            DriveState.NOT_READY: "not ready to switch on",
            DriveState.DISABLED: "switch on disabled",
            DriveState.READY: "ready to switch on",
            DriveState.SWITCHED_ON: "switched on",
            DriveState.ENABLED: "operation enabled",
            DriveState.QUICK_STOP: "quick stop active",
            DriveState.FAULT_REACTION: "fault reaction active",
            DriveState.FAULT: "fault",
        }[self]


_BY_SIX = {int(s): s for s in (DriveState.READY, DriveState.SWITCHED_ON, DriveState.ENABLED)}
_BY_SIX[int(DriveState.QUICK_STOP)] = DriveState.QUICK_STOP
_BY_FOUR = {
    int(s): s
    for s in (
        DriveState.NOT_READY,
        DriveState.DISABLED,
        DriveState.FAULT_REACTION,
        DriveState.FAULT,
    )
}
OUT, BACK = struct.Struct("<Hh"), struct.Struct("<Hih")


def drive_state(statusword: int) -> DriveState:
    """The state in a statusword.

    Raises:
        ProtocolError: it shows none.
    """
    found = _BY_SIX.get(statusword & 0x6F) or _BY_FOUR.get(statusword & 0x4F)
    if found is None:
        raise ProtocolError(f"the statusword 0x{statusword:04x} shows no state of a CiA 402 drive")
    return found


def command(control: Controlword, target: int) -> bytes:
    """A receive PDO: controlword and target torque (thousandths of the rated one)."""
    return OUT.pack(control, target)


def answer(data: bytes) -> tuple[DriveState, int, int]:
    """State, position (increments) and torque demand (thousandths) in a transmit PDO.

    Raises:
        ProtocolError: it is none.
    """
    if len(data) != BACK.size:
        raise ProtocolError(f"a drive's process data have {BACK.size} bytes, {len(data)} came")
    status, position, demand = BACK.unpack(data)
    return drive_state(status), position, demand
