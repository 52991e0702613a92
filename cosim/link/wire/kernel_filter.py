"""A filter that the kernel applies before a datagram takes room in a socket's queue (Linux).

It is a classic BPF program (McCanne and Jacobson, 1993; Linux, Documentation/networking/filter).
Datagrams that are longer than any of the link's never enter, so a few of 64 KiB cannot fill the
queue. In a flood it lets in only what could be the session's next packet. Elsewhere than on Linux
nothing is filtered, and only the loop's own bound on reads holds.
"""

from __future__ import annotations

import ctypes
import socket
import struct
import sys

from cosim.link.wire.packet import HEADER, LARGEST_DATAGRAM, MAGIC, VERSION, PacketKind

Instruction = tuple[int, int, int, int]
"""Code, jump if true, jump if false, operand."""

_SO_ATTACH_FILTER = 26
_SO_MEMINFO = 55
_MEMINFO = struct.Struct("@9I")
_DROPS = 8
_INSTRUCTION = struct.Struct("@HBBI")
_PROGRAM = struct.Struct("@HP")
# Codes of <linux/bpf_common.h>: load a word, a byte, the length; compare; return.
_WORD, _BYTE, _LENGTH = 0x20, 0x30, 0x80
_EQUAL, _GREATER, _AT_LEAST = 0x15, 0x25, 0x35
_RETURN = 0x06
_UDP_HEADER = 8
_WHOLE = 0xFFFF


def _lettered(kind: int) -> int:
    """The datagram's first four bytes as the filter loads them."""
    return int.from_bytes(MAGIC + bytes((VERSION, kind)), "big")


def size_filter() -> list[Instruction]:
    """Lets in what is no longer than the largest datagram of the link."""
    return [
        (_LENGTH, 0, 0, 0),
        (_GREATER, 0, 1, _UDP_HEADER + LARGEST_DATAGRAM),
        (_RETURN, 0, 0, 0),
        (_RETURN, 0, 0, _WHOLE),
    ]


def session_filter(session: int, floor: int, *, handshakes: bool) -> list[Instruction]:
    """Lets in data of ``session`` with sequences from ``floor`` on, and ``handshakes``."""
    low, high = struct.unpack(">II", struct.pack("<Q", session))
    body = _UDP_HEADER + 8
    # Jumps to (accept, drop) are written as -1 and -2 and resolved at the end.
    accept, drop = -1, -2
    program: list[Instruction] = [
        (_LENGTH, 0, 0, 0),
        (_GREATER, drop, 0, _UDP_HEADER + LARGEST_DATAGRAM),
        (_AT_LEAST, 0, drop, _UDP_HEADER + HEADER.size),
        (_WORD, 0, 0, _UDP_HEADER),
    ]
    if handshakes:
        program += [
            (_AT_LEAST, 0, 1, _lettered(PacketKind.HELLO)),
            (_GREATER, drop, accept, _lettered(PacketKind.KEEP)),
        ]
    program += [
        (_EQUAL, 0, drop, _lettered(PacketKind.DATA)),
        (_WORD, 0, 0, body),
        (_EQUAL, 0, drop, low),
        (_WORD, 0, 0, body + 4),
        (_EQUAL, 0, drop, high),
    ]
    # The sequence is little-endian: from its highest byte down. Beyond 32 bits (a year at 128 Hz)
    # the floor is left out.
    if 0 < floor < 1 << 32:
        for place in (3, 2, 1, 0):
            byte = floor >> 8 * place & 0xFF
            program.append((_BYTE, 0, 0, body + 8 + place))
            if place:
                program += [(_GREATER, accept, 0, byte), (_EQUAL, 0, drop, byte)]
            else:
                program.append((_AT_LEAST, accept, drop, byte))
    ends = {accept: len(program), drop: len(program) + 1}

    def distance(jump: int, at: int) -> int:
        return ends[jump] - at - 1 if jump < 0 else jump

    resolved = [
        (code, distance(yes, at), distance(no, at), operand)
        for at, (code, yes, no, operand) in enumerate(program)
    ]
    return [*resolved, (_RETURN, 0, 0, _WHOLE), (_RETURN, 0, 0, 0)]


def attach(link: socket.socket, program: list[Instruction]) -> bool:
    """Put ``program`` before the socket's queue, in place of the one before; whether it is on."""
    if sys.platform != "linux":
        return False
    code = b"".join(_INSTRUCTION.pack(*instruction) for instruction in program)
    buffer = ctypes.create_string_buffer(code, len(code))
    try:
        link.setsockopt(
            socket.SOL_SOCKET,
            _SO_ATTACH_FILTER,
            _PROGRAM.pack(len(program), ctypes.addressof(buffer)),
        )
    except OSError:
        return False
    return True


def dropped(link: socket.socket) -> int:
    """Datagrams that never came into the socket's queue: filtered, or it was full."""
    if sys.platform != "linux":
        return 0
    try:
        facts = link.getsockopt(socket.SOL_SOCKET, _SO_MEMINFO, _MEMINFO.size)
    except OSError:
        return 0
    return int(_MEMINFO.unpack(facts)[_DROPS]) if len(facts) == _MEMINFO.size else 0
