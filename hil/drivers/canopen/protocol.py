"""CANopen frames: NMT, SYNC, EMCY, heartbeat, process data, and expedited SDO; little-endian.

Identifiers are the pre-defined connection set. Nothing here keeps state, so a damaged frame can
spoil nothing but itself: the next valid one is read as if it had never been.
Sources: CiA 301 (communication), CiA 406 (encoders), CiA 401 (analogue outputs).
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

from hil.device.errors import ProtocolError

NMT, SYNC = 0x000, 0x080
_EMERGENCY, _POSITIONS, _OUTPUTS = 0x080, 0x180, 0x200
_SDO_ANSWER, _SDO_REQUEST, _HEARTBEAT = 0x580, 0x600, 0x700
LAST_NODE = 127
INVALID = 1 << 31
"""Set in a PDO's COB-ID entry: the PDO does not exist."""
EVERY_SYNC, AT_ONCE = 1, 255
"""Transmission types: sampled and sent at each SYNC; taken over on reception."""


HEARTBEAT_MISSING, RPDO_MISSING = 0x8130, 0x8250
"""Emergency codes of a node that misses our heartbeat, or a receive PDO by its timer (CiA 301)."""


class NmtCommand(IntEnum):
    """What a master asks of a node."""

    START = 1
    STOP = 2
    PRE_OPERATIONAL = 128
    RESET = 129
    RESET_COMMUNICATION = 130


class NmtState(IntEnum):
    """What a heartbeat says; BOOT_UP comes once, after a reset."""

    BOOT_UP = 0
    STOPPED = 4
    OPERATIONAL = 5
    PRE_OPERATIONAL = 127


class Index(IntEnum):
    """Objects of the dictionary that are used here."""

    ERROR_REGISTER = 0x1001
    HEARTBEAT_CONSUMER = 0x1016
    HEARTBEAT_PRODUCER = 0x1017
    IDENTITY = 0x1018
    ERROR_BEHAVIOUR = 0x1029
    RPDO = 0x1400
    RPDO_MAPPING = 0x1600
    TPDO = 0x1800
    TPDO_MAPPING = 0x1A00
    UNITS_PER_TURN = 0x6001
    RANGE = 0x6002
    PRESET = 0x6003
    POSITION = 0x6004
    PRESETS = 0x6010
    POSITIONS = 0x6020
    OUTPUT = 0x6411
    OUTPUT_ERROR_MODE = 0x6443
    OUTPUT_ERROR_VALUE = 0x6444


LOGICAL_DEVICE = 0x800
"""A node with several devices repeats the profile area at this distance (CiA 301)."""


def emergency_id(node: int) -> int:
    """Identifier of a node's emergencies."""
    return _EMERGENCY + node


def positions_id(node: int) -> int:
    """Identifier of a node's first transmit PDO."""
    return _POSITIONS + node


def outputs_id(node: int) -> int:
    """Identifier of a node's first receive PDO."""
    return _OUTPUTS + node


def sdo_request_id(node: int) -> int:
    """Identifier of requests to a node's SDO server."""
    return _SDO_REQUEST + node


def sdo_answer_id(node: int) -> int:
    """Identifier of its answers."""
    return _SDO_ANSWER + node


def heartbeat_id(node: int) -> int:
    """Identifier of a node's heartbeat and boot-up message."""
    return _HEARTBEAT + node


def nmt(command: NmtCommand, node: int) -> bytes:
    """An NMT command to one node (0: to all)."""
    return bytes((command, node))


def heartbeat(state: NmtState) -> bytes:
    """A heartbeat."""
    return bytes((state,))


def state(data: bytes) -> NmtState:
    """The state in a heartbeat.

    Raises:
        ProtocolError: it is not one byte, or no state.
    """
    try:
        if len(data) == 1:
            return NmtState(data[0])
    except ValueError:
        pass
    raise ProtocolError(f"a CANopen heartbeat is one byte with a state, '{data.hex()}' came")


@dataclass(frozen=True, slots=True)
class Emergency:
    """What a node reports; code 0 takes earlier reports back."""

    code: int
    register: int
    vendor: bytes

    def __str__(self) -> str:
        meaning = next(text for least, text in _MEANINGS if self.code >= least)
        return (
            f"emergency 0x{self.code:04x} ({meaning}), error register 0x{self.register:02x}, "
            f"vendor bytes {self.vendor.hex(' ')}"
        )


_MEANINGS = (
    (0xFF00, "device specific"),
    (0xF000, "additional functions"),
    (0x9000, "external"),
    (0x8260, "protocol"),
    (0x8250, "the master's commands are missing"),
    (0x8200, "protocol"),
    (0x8130, "the master's heartbeat is missing"),
    (0x8100, "communication"),
    (0x8000, "monitoring"),
    (0x7000, "additional modules"),
    (0x6000, "device software"),
    (0x5000, "device hardware"),
    (0x4000, "temperature"),
    (0x3000, "voltage"),
    (0x2000, "current"),
    (0x1000, "generic"),
    (0x0000, "no error"),
)
"""Error classes from this code on (CiA 301)."""


def emergency(data: bytes) -> Emergency:
    """An emergency.

    Raises:
        ProtocolError: it is not 8 bytes.
    """
    if len(data) != 8:
        raise ProtocolError(f"a CANopen emergency has 8 bytes, {len(data)} came")
    code, register = struct.unpack_from("<HB", data)
    return Emergency(code, register, data[3:])


def mapping(index: int, subindex: int, bits: int) -> int:
    """A PDO mapping entry: 6004h:0 of 32 bits is 0x60040020."""
    return index << 16 | subindex << 8 | bits


def consumer(node: int, milliseconds: int) -> int:
    """An entry of 1016h: whose heartbeat is expected, and how often at least."""
    return node << 16 | milliseconds


def positions(data: bytes, count: int) -> tuple[int, ...]:
    """Position values (signed 32 bits) of a PDO that has ``count`` of them.

    Raises:
        ProtocolError: it has another length: the node's mapping is not the one that was set up.
    """
    if len(data) != 4 * count:
        raise ProtocolError(f"{count} CANopen positions have {4 * count} bytes, {len(data)} came")
    return struct.unpack(f"<{count}i", data)


def step(last: int, now: int, span: int) -> int:
    """How far a position moved that begins anew after ``span`` units: the shorter way round."""
    return (now - last + span // 2) % span - span // 2


def outputs(codes: Sequence[int]) -> bytes:
    """A PDO of analogue output values (signed 16 bits)."""
    return struct.pack(f"<{len(codes)}h", *codes)


@dataclass(frozen=True, slots=True)
class Object:
    """An entry of the object dictionary, of ``size`` bytes (1 to 4)."""

    index: int
    subindex: int
    size: int

    def __str__(self) -> str:
        return f"{self.index:04X}h:{self.subindex}"


@dataclass(frozen=True, slots=True)
class SdoAnswer:
    """An SDO server's answer about an object; ``value`` is ``None`` after a download.

    ``abort`` is the code of a refusal, 0 for none. The value is unsigned.
    """

    index: int
    subindex: int
    value: int | None = None
    abort: int = 0

    def is_for(self, entry: Object) -> bool:
        """Whether it answers a request about an object."""
        return (self.index, self.subindex) == (entry.index, entry.subindex)


_DOWNLOAD, _UPLOAD, _DOWNLOADED, _ABORTED = 0x20, 0x40, 0x60, 0x80
_EXPEDITED, _SIZED = 0x02, 0x01
_UPLOADED = {0x42: 4} | {0x43 | (4 - size) << 2: size for size in (1, 2, 3, 4)}
"""Command byte of an expedited upload's answer, and how many bytes it brings."""
_GENERAL_ERROR = 0x08000000


def sdo_upload(entry: Object) -> bytes:
    """A request to read an object."""
    return struct.pack("<BHBI", _UPLOAD, entry.index, entry.subindex, 0)


def sdo_download(entry: Object, value: int) -> bytes:
    """A request to write an object of up to 4 bytes; negative values as two's complement."""
    command = _DOWNLOAD | (4 - entry.size) << 2 | _EXPEDITED | _SIZED
    value &= (1 << 8 * entry.size) - 1
    return struct.pack("<BHBI", command, entry.index, entry.subindex, value)


def sdo_answer(data: bytes) -> SdoAnswer:
    """An answer to one of the two.

    Raises:
        ProtocolError: it is nothing that those requests are answered with.
    """
    if len(data) != 8:
        raise ProtocolError(f"an SDO answer has 8 bytes, {len(data)} came")
    command, index, subindex, value = struct.unpack("<BHBI", data)
    if command == _ABORTED:
        return SdoAnswer(index, subindex, abort=value or _GENERAL_ERROR)
    if command == _DOWNLOADED:
        return SdoAnswer(index, subindex)
    if command in _UPLOADED:
        return SdoAnswer(index, subindex, value & (1 << 8 * _UPLOADED[command]) - 1)
    raise ProtocolError(f"an SDO answer that nothing asked for: '{data.hex()}'")
