"""Haply 2DIY (hAPI) over USB serial: the host's frames and the board's reply.

Little-endian float32, no sync word, no length, no checksum: a lost byte shifts everything after it,
and only a reset with a new setup brings both sides together again. Values are ordered by *port*.
Source: the published hAPI host libraries (HaplyHAPI 1.0.1) and the maker's documentation.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from hil.device.errors import ProtocolError
from hil.safety.linkage import Pair

RESET, SETUP, IO = 0, 1, 2
PORTS = 4
REPLY_BYTES = 9
IO_BYTES = 10
LARGEST_DEGREES = 3600.0
"""An angle beyond ten turns is no angle of a five-bar."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HaplyAxis:
    """One motor and its encoder; ``port`` is 1 to 4, ``rotation`` the hAPI's 0 (CW) or 1 (CCW)."""

    port: int
    rotation: int = 1
    offset: float = 0.0
    """Encoder angle at the moment of setup (degrees)."""
    counts_per_turn: float = 4880.0


def reset(device: int) -> bytes:
    """Forget the setup. It does not zero the motors."""
    return bytes((RESET, device))


def setup(device: int, axes: Sequence[HaplyAxis]) -> bytes:
    """Say which ports have motors and encoders, and preset the encoders (26 bytes for two)."""
    ordered = sorted(axes, key=lambda axis: axis.port)
    mask = sum(1 << (axis.port - 1) for axis in ordered)
    rotations = [axis.rotation for axis in ordered]
    head = bytes((SETUP, device, mask, *rotations, mask, *rotations, 0, 0))
    return head + b"".join(
        struct.pack("<ff", axis.offset, axis.counts_per_turn) for axis in ordered
    )


def torques(device: int, axes: Sequence[HaplyAxis], values: Pair) -> bytes:
    """Command motor torques (N.m), given in the order of ``axes``."""
    by_port = [value for _, value in sorted(zip((a.port for a in axes), values, strict=True))]
    return struct.pack("<BBff", IO, device, *by_port)


def angles(device: int, axes: Sequence[HaplyAxis], reply: bytes) -> Pair:
    """Encoder angles (degrees) of a reply, in the order of ``axes``.

    Raises:
        ProtocolError: it cannot be a reply of this device; nothing in it can be trusted.
    """
    if len(reply) != REPLY_BYTES:
        raise ProtocolError(f"a Haply reply has {REPLY_BYTES} bytes, {len(reply)} came")
    address, first, second = struct.unpack("<Bff", reply)
    if address != device:
        raise ProtocolError(f"a reply of device {address} came, this is device {device}")
    if not all(isfinite(value) and abs(value) < LARGEST_DEGREES for value in (first, second)):
        raise ProtocolError("a reply holds something that is no angle")
    return (first, second) if axes[0].port < axes[1].port else (second, first)
