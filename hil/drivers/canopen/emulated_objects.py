"""The object dictionary of an emulated CANopen node: two encoder channels, two analogue outputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, cast

import canopen
from canopen.objectdictionary import ODArray, ODRecord, ODVariable, datatypes

U8, U16, U32 = datatypes.UNSIGNED8, datatypes.UNSIGNED16, datatypes.UNSIGNED32
I16, I32 = datatypes.INTEGER16, datatypes.INTEGER32
TEXT = datatypes.VISIBLE_STRING

VARIABLES = (
    (0x1000, "Device type", U32, "ro", 0x0002_0196),
    (0x1001, "Error register", U8, "ro", 0),
    (0x1005, "COB-ID SYNC", U32, "rw", 0x80),
    (0x1008, "Device name", TEXT, "ro", "cohaptic emulated two-axis node"),
    (0x1017, "Producer heartbeat time", U16, "rw", 0),
    (0x6001, "Measuring units per revolution", U32, "rw", 20000),
    (0x6002, "Total measuring range", U32, "rw", 20000 * 4096),
    (0x6003, "Preset value", U32, "rw", 0),
    (0x6004, "Position value", U32, "ro", 0),
)
"""Index, name, type, access, default."""

LISTS = (
    (0x1016, "Consumer heartbeat time", "rw", [("Consumer 1", U32, 0)]),
    (
        0x1018,
        "Identity",
        "ro",
        [("Vendor", U32, 0), ("Product", U32, 0), ("Revision", U32, 1), ("Serial", U32, 4711)],
    ),
    (0x1029, "Error behaviour", "rw", [("Communication error", U8, 0)]),
    (0x6010, "Preset values, multi-sensor", "rw", [("Channel 1", I32, 0), ("Channel 2", I32, 0)]),
    (0x6020, "Position values, multi-sensor", "ro", [("Channel 1", I32, 0), ("Channel 2", I32, 0)]),
    (0x6411, "Write analogue output", "rw", [("Output 1", I16, 0), ("Output 2", I16, 0)]),
    (0x6443, "Analogue output error mode", "rw", [("Output 1", U8, 0), ("Output 2", U8, 0)]),
    (0x6444, "Analogue output error value", "rw", [("Output 1", I32, 3277), ("Output 2", I32, 0)]),
)
"""Index, name, access, members from sub-index 1 on.

As a careless maker leaves them: outputs hold on an error (6443h), or would give 1 V (6444h).
"""

PDOS = (
    (0x1400, 0x1600, "RPDO 1", 0x200, 255, (0x64110110, 0x64110210)),
    (0x1800, 0x1A00, "TPDO 1", 0x180, 255, (0x60040020, 0)),
    (0x1801, 0x1A01, "TPDO 2", 0x280, 255, (0x60200120, 0x60200220)),
)
"""Parameters, mapping, name, COB-ID without the node, transmission type, mapped objects.

As it comes from its maker: event-driven, and with a second transmit PDO that nobody asked for.
"""


def dictionary(node: int) -> canopen.ObjectDictionary:
    """The dictionary of one node with encoders and outputs."""
    return dictionary_of(node, VARIABLES, LISTS, PDOS)


def dictionary_of(
    node: int,
    variables: Sequence[tuple[int, str, int, str, Any]],
    lists: Sequence[tuple[int, str, str, list[tuple[str, int, int]]]],
    pdos: Sequence[tuple[int, int, str, int, int, tuple[int, ...]]],
) -> canopen.ObjectDictionary:
    """A dictionary of what is in such tables; a PDO may have an event timer (sub-index 5)."""
    made = canopen.ObjectDictionary()
    for index, name, kind, access, default in variables:
        made.add_object(_variable((index, 0), name, kind, access, default))
    for index, name, access, members in lists:
        entries = [(*member, access) for member in members]
        made.add_object(_filled(ODArray(name, index), entries, "ro"))
    for parameters, mapping, name, identifier, kind, mapped in pdos:
        entries = [
            ("COB-ID", U32, identifier + node, "rw"),
            ("Transmission type", U8, kind, "rw"),
            ("Inhibit time", U16, 0, "rw"),
            ("Reserved", U8, 0, "rw"),
            ("Event timer", U16, 0, "rw"),
        ]
        made.add_object(_filled(ODRecord(name, parameters), entries, "ro"))
        entries = [(f"Entry {n}", U32, each, "rw") for n, each in enumerate(mapped, start=1)]
        used = sum(each != 0 for each in mapped)
        made.add_object(_filled(ODRecord(f"{name} mapping", mapping), entries, "rw", used))
    return made


def _filled(
    holder: Any, members: list[tuple[str, int, int, str]], access: str, count: int | None = None
) -> Any:
    length = len(members) if count is None else count
    holder.add_member(_variable((holder.index, 0), "Number of entries", U8, access, length))
    for subindex, (name, kind, default, allowed) in enumerate(members, start=1):
        holder.add_member(_variable((holder.index, subindex), name, kind, allowed, default))
    return holder


def _variable(
    place: tuple[int, int], name: str, kind: int, access: str, default: int | str
) -> ODVariable:
    made = ODVariable(name, *place)
    made.data_type, made.access_type, made.default = kind, access, cast("Any", default)
    return made
