"""Every field of every reply, what it may absurdly say, and what a device makes of that.

docs/safety.md shows the table. Where the answer to a field has no consequence, the reason stands
in the consequence's place.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from math import nan

from tests.support.hil.spoiled_replies import (
    ENABLED,
    FAULT,
    FIRED,
    ZERO,
    Spoil,
    besides,
    can,
    cobs,
    frozen,
    haply,
    packed,
)

LOST = "no valid sample"
"""What a reply that is no sample ends in: data age, then a fault."""


@dataclass(frozen=True)
class Said:
    """One field's odd value; ``words`` are of the fault's sentence, else ``why`` there is none."""

    board: str
    field: str
    value: str
    spoil: Spoil
    words: str = ""
    why: str = ""
    inactive: bool = False
    """Whether it is said while nothing is commanded."""


def _sdo(command: int, value: int):
    """An SDO server's answers about outputs, with another command byte and value."""

    def change(data: bytes) -> bytes:
        index = struct.unpack_from("<H", data, 1)[0]
        return (
            struct.pack("<B", command) + data[1:4] + struct.pack("<I", value)
            if (index == 0x6411)
            else data
        )

    return can(0x581, change)


def _both(first: Spoil, second: Spoil) -> Spoil:
    return lambda answer: second(first(answer))


_BEAT, _EST = 0x001, 0x009
TABLE = (
    # --- Haply -----------------------------------------------------------------------------------
    Said("haply", "device", "another one", haply(0, 6), "reply of device 6"),
    Said("haply", "angle 1", "nan", haply(1, nan), "no angle"),
    Said("haply", "angle 2", "1e9 degrees", haply(5, 1e9), "no angle"),
    Said("haply", "angle 2", "leaps by 90 degrees", haply(5, 200.0), "jumped"),
    Said("haply", "length", "one byte more", lambda answer: answer + b"\0", "nobody asked for"),
    Said("haply", "length", "one byte less", lambda answer: answer[:-1], "out of step"),
    # --- framed boards ---------------------------------------------------------------------------
    Said("cobs", "kind", "another", cobs(kind=0x82), LOST),
    Said("cobs", "status ENABLED", "off while active", cobs(status=ZERO), "output stage is off"),
    Said(
        "cobs",
        "status ENABLED",
        "on while inactive",
        cobs(status=lambda old: old | ENABLED),
        "output stage is on",
        inactive=True,
    ),
    Said(
        "cobs",
        "status WATCHDOG_FIRED",
        "while active",
        cobs(status=lambda old: old | FIRED),
        "watchdog has fired",
    ),
    Said(
        "cobs",
        "status WATCHDOG_FIRED",
        "while inactive",
        cobs(status=lambda old: old | FIRED),
        why="the next activation clears it, and judges it from then on",
        inactive=True,
    ),
    Said(
        "cobs",
        "status ZERO",
        "while it is to push",
        cobs(status=lambda s: s | ZERO),
        "told to push",
    ),
    Said(
        "cobs",
        "status ZERO",
        "missing at zero",
        cobs(status=lambda old: old & ~ZERO),
        "not at zero, though it was told to be",
        inactive=True,
    ),
    Said(
        "cobs", "status FAULT", "while active", cobs(status=lambda s: s | FAULT), "reports .*FAULT"
    ),
    Said(
        "cobs",
        "status FAULT",
        "while inactive",
        cobs(status=lambda old: old | FAULT),
        "reports .*FAULT",
        inactive=True,
    ),
    Said(
        "cobs",
        "status INPUT",
        "closed",
        cobs(status=lambda old: old | 16),
        why="asked only of a switch that serves as the dead man, which has to be seen open first",
    ),
    Said("cobs", "status", "an unknown bit", cobs(status=lambda s: s | 32), "another version"),
    Said("cobs", "sequence", "an old one", cobs(sequence=lambda old: old - 9 & 0xFFFF), LOST),
    Said("cobs", "sequence", "one of the future", cobs(sequence=lambda s: s + 9 & 0xFFFF), LOST),
    Said("cobs", "sequence", "always the same", frozen("sequence"), LOST),
    Said("cobs", "microseconds", "stand still", frozen("time"), "clock stands still"),
    Said("cobs", "microseconds", "begins anew", cobs(time=lambda old: old % 1000), "started anew"),
    Said("cobs", "count", "leaps by a turn", cobs(second=lambda old: old + 20000), "jumped"),
    Said("cobs", "spare field", "not zero", cobs(spare=1), "another version"),
    Said("cobs", "length", "two frames in one", lambda answer: answer[:-1] + answer, LOST),
    # --- ODrive ----------------------------------------------------------------------------------
    Said(
        "odrive",
        "heartbeat error",
        "a bit of axis 1",
        can(1 << 5 | _BEAT, packed("<I", 0, 0x40)),
        "axis 1 reports error 0x00000040",
    ),
    Said(
        "odrive",
        "heartbeat error",
        "a bit while inactive",
        can(_BEAT, packed("<I", 0, 0x40)),
        "axis 0 reports error",
        inactive=True,
    ),
    Said(
        "odrive",
        "heartbeat error",
        "watchdog expired while inactive",
        can(_BEAT, packed("<I", 0, 0x01000000)),
        why="an idle axis that nobody talks to; the next activation clears it",
        inactive=True,
    ),
    Said(
        "odrive",
        "heartbeat state",
        "idle while active",
        can(_BEAT, packed("<B", 4, 1)),
        "axis 0 left closed loop, it is idle",
    ),
    Said(
        "odrive",
        "heartbeat state",
        "one that is none",
        can(1 << 5 | _BEAT, packed("<B", 4, 77)),
        "axis 1 left closed loop, it is in state 77",
    ),
    Said(
        "odrive",
        "heartbeat state",
        "closed loop while inactive",
        can(_BEAT, packed("<B", 4, 8)),
        "axis 0 was told to be idle",
        inactive=True,
    ),
    Said(
        "odrive",
        "heartbeat length",
        "5 bytes",
        can(_BEAT, lambda data: data[:5]),
        "8 bytes, 5 came",
    ),
    Said(
        "odrive",
        "heartbeat flags (bytes 5 to 7)",
        "all set",
        can(_BEAT, packed("<I", 4, 0xFFFFFF08)),
        why="not decoded: results of calibrations and trajectories, of which there are none here",
    ),
    Said("odrive", "estimates position", "nan", can(_EST, packed("<f", 0, nan)), "no numbers"),
    Said("odrive", "estimates position", "a turn away", can(_EST, packed("<f", 0, 1.0)), "jumped"),
    Said("odrive", "estimates velocity", "nan", can(_EST, packed("<f", 4, nan)), "no numbers"),
    Said(
        "odrive",
        "estimates velocity",
        "50 turns/s",
        can(1 << 5 | _EST, packed("<f", 4, -50.0)),
        "axis 1 says that it turns at -314 rad/s",
    ),
    Said("odrive", "estimates length", "7 bytes", can(_EST, lambda d: d[:7]), "8 bytes, 7 came"),
    # --- CANopen ---------------------------------------------------------------------------------
    Said("canopen", "heartbeat state", "stopped", can(0x701, lambda _: b"\4"), "became stopped"),
    Said("canopen", "heartbeat state", "boot-up", can(0x701, lambda _: b"\0"), "started anew"),
    Said("canopen", "heartbeat state", "none", can(0x701, lambda _: b"\x33"), "byte with a state"),
    Said("canopen", "heartbeat length", "2 bytes", can(0x701, lambda _: b"\5\5"), "one byte"),
    Said(
        "canopen",
        "emergency code",
        "an error",
        besides(0x081, struct.pack("<HB5x", 0x5000, 1)),
        "emergency 0x5000",
    ),
    Said(
        "canopen",
        "emergency code",
        "0: taken back",
        besides(0x081, bytes(8)),
        why="no error is left; one that was there has ended in FAULT before",
    ),
    Said(
        "canopen",
        "emergency register",
        "an error, with code 0",
        besides(0x081, struct.pack("<HB5x", 0, 0x11)),
        "error register 0x11",
    ),
    Said(
        "canopen",
        "emergency vendor",
        "five bytes",
        besides(0x081, struct.pack("<HB5B", 0x5000, 1, 9, 8, 7, 6, 5)),
        "vendor bytes 09 08 07 06 05",
    ),
    Said("canopen", "emergency length", "3 bytes", besides(0x081, b"\0\0\0"), "8 bytes, 3 came"),
    Said(
        "canopen",
        "positions",
        "leap by a turn",
        can(0x181, packed("<i", 0, 10**6)),
        "jumped",
    ),
    Said("canopen", "positions length", "4 bytes", can(0x181, lambda d: d[:4]), "bytes, 4 came"),
    Said(
        "canopen",
        "SDO value",
        "an output that is not at zero",
        _sdo(0x4B, 1000),
        "told zero, and its output is 0x3e8",
        inactive=True,
    ),
    Said(
        "canopen",
        "SDO abort",
        "refuses to tell",
        _sdo(0x80, 0x08000000),
        "refuses to tell its output",
        inactive=True,
    ),
    Said(
        "canopen",
        "SDO index, subindex",
        "of another object",
        can(0x581, packed("<H", 1, 0x2000)),
        why="answers nobody's question; no zero is confirmed by it",
        inactive=True,
    ),
    Said("canopen", "SDO command", "none", can(0x581, packed("<B", 0, 0xE0)), "SDO", inactive=True),
    # --- CiA 402 ---------------------------------------------------------------------------------
    Said("cia402", "statusword state", "fault", can(0x182, packed("<H", 0, 8)), "state 'fault'"),
    Said(
        "cia402",
        "statusword state",
        "quick stop",
        can(0x181, packed("<H", 0, 0x07)),
        "state 'quick stop active'",
    ),
    Said(
        "cia402",
        "statusword state",
        "switched on while active",
        can(0x181, packed("<H", 0, 0x23)),
        "output stage is off",
    ),
    Said(
        "cia402",
        "statusword state",
        "enabled while inactive",
        _both(can(0x181, packed("<H", 0, 0x27)), can(0x182, packed("<H", 0, 0x27))),
        "output stage is on",
        inactive=True,
    ),
    Said("cia402", "statusword state", "none", can(0x181, packed("<H", 0, 0x0B)), "no state"),
    Said(
        "cia402",
        "statusword bits 4, 7, 9 to 15",
        "all set",
        can(0x181, packed("<H", 0, 0xFE90 | 0x27)),
        why="not used: whether a drive follows is seen in its torque demand",
    ),
    Said("cia402", "position", "leaps by a turn", can(0x182, packed("<i", 2, 10**6)), "jumped"),
    Said(
        "cia402",
        "torque demand",
        "another than was told",
        can(0x181, packed("<h", 6, 900)),
        "drive 1 demands 900 thousandths",
    ),
    Said(
        "cia402",
        "torque demand",
        "zero while it is to push",
        can(0x182, packed("<h", 6, 0)),
        "drive 2 demands 0 thousandths",
    ),
    Said(
        "cia402",
        "torque demand",
        "some while inactive",
        can(0x181, packed("<h", 6, -20)),
        "demands -20 thousandths of its rated torque .* told 0",
        inactive=True,
    ),
    Said("cia402", "answer length", "6 bytes", can(0x181, lambda d: d[:6]), "8 bytes, 6 came"),
    Said("cia402", "heartbeat state", "stopped", can(0x702, lambda _: b"\4"), "became stopped"),
    Said(
        "cia402",
        "emergency code",
        "an error",
        besides(0x082, struct.pack("<HB5x", 0x2310, 1)),
        "CANopen node 2 reports emergency 0x2310",
    ),
)
