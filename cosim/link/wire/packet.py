"""The bytes of a packet, and its seal; ``docs/protocol.md`` describes both for other programs.

A datagram is a header in the clear, a sealed body and a tag. The header is authenticated with the
body (AES-256-GCM, NIST SP 800-38D); kind, stream and sequence make the nonce, so none repeats
under a key as long as a sequence never restarts.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence
from enum import IntEnum

import numpy as np
from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from numpy.typing import NDArray

Floats = NDArray[np.float64]

MAGIC = b"cH"
VERSION = 2
HEADER = struct.Struct("<2sBBHHQQ")
"""magic, version, kind, stream, zero, session, sequence."""
BODY = struct.Struct("<qqqqqqIIq")
"""tick, sent, echo_sent, echo_received, epoch, acknowledged, flags, its session (low half), content
(the tick from which on the values have been the same)."""
NONCE = struct.Struct("<BBHQ")
"""kind, zero, stream, sequence."""
TAG_SIZE = 16
LARGEST_DATAGRAM = 1232
LARGEST_TIME = 1 << 60
"""ns (36 years): a clock that shows more is not believed, and sums of four still fit 64 bits."""
LOW_HALF = 0xFFFF_FFFF
BODY_START = HEADER.size
VALUES_START = HEADER.size + BODY.size


class PacketKind(IntEnum):
    """What a datagram is; the upper half never reaches a loop's values."""

    DATA = 1
    HELLO = 16
    REPLY = 17
    REFUSE = 18
    COOKIE = 19
    PRESENT = 20
    KEEP = 21
    PROBE = 32
    ECHO = 33


class PacketFlag(IntEnum):
    """Bits of a data packet's flags."""

    STOPPING = 1
    INITIAL = 2
    WITHHELD = 4
    """Only what tells how the source is; its other values are those of before."""


FLAGS = PacketFlag.STOPPING | PacketFlag.INITIAL | PacketFlag.WITHHELD
"""Every bit that means something; a packet with another one is not believed."""


def datagram_size(elements: int) -> int:
    """Bytes of a data packet with that many float64 elements."""
    return VALUES_START + 8 * elements + TAG_SIZE


class Sealer:
    """Seals datagrams of one session and direction with strictly increasing sequences.

    Every kind and stream counts its own sequence from 0. A sealer is never copied or restarted:
    that would repeat nonces under one key.
    """

    def __init__(self, key: bytes, session: int) -> None:
        self._cipher = AESGCM(key)
        self._session = session
        self._next: dict[int, int] = {}
        self._nonce = bytearray(NONCE.size)

    def seal(self, kind: PacketKind, stream: int, plain: memoryview, datagram: memoryview) -> int:
        """Write header, sealed ``plain`` and tag into ``datagram``; return the sequence used."""
        slot = (kind << 16) | stream
        sequence = self._next.get(slot, 0)
        self._next[slot] = sequence + 1
        HEADER.pack_into(datagram, 0, MAGIC, VERSION, kind, stream, 0, self._session, sequence)
        NONCE.pack_into(self._nonce, 0, kind, 0, stream, sequence)
        header, sealed = datagram[:BODY_START], datagram[BODY_START:]
        self._cipher.encrypt_into(self._nonce, plain, header, sealed)
        return sequence


class Opener:
    """Opens what the peer's :class:`Sealer` sealed; stateless, so a forgery changes nothing."""

    def __init__(self, key: bytes, session: int) -> None:
        self._cipher = AESGCM(key)
        self.session = session
        self._nonce = bytearray(NONCE.size)

    def open(self, datagram: memoryview, plain: memoryview) -> bool:
        """Decrypt into ``plain`` (``len(datagram)`` - 40 bytes); ``False`` for a forgery."""
        _, _, kind, stream, _, _, sequence = HEADER.unpack_from(datagram)
        return self.open_as(kind, stream, sequence, datagram, plain)

    def open_as(
        self, kind: int, stream: int, sequence: int, datagram: memoryview, plain: memoryview
    ) -> bool:
        """The same for a caller that has read the header."""
        NONCE.pack_into(self._nonce, 0, kind, 0, stream, sequence)
        header, sealed = datagram[:BODY_START], datagram[BODY_START:]
        try:
            self._cipher.decrypt_into(self._nonce, sealed, header, plain)
        except InvalidTag:
            return False
        return True


class DataWriter:
    """Writes the data packets of one stream; ``values`` is a view on the packet's elements."""

    def __init__(
        self, sealer: Sealer | None, stream: int, elements: int, head: Sequence[int] = ()
    ) -> None:
        """``head`` has the elements that travel where the others are withheld."""
        size = datagram_size(elements)
        plain = bytearray(size - HEADER.size - TAG_SIZE)
        self._plain = memoryview(plain)
        self._numbers = struct.Struct(f"<{elements}d")
        self._whole = memoryview(bytearray(size))
        self._head = tuple(head)
        self._short = self._whole[: datagram_size(len(self._head))]
        self._short_plain = memoryview(bytearray(len(self._short) - HEADER.size - TAG_SIZE))
        self._short_numbers = struct.Struct(f"<{len(self._head)}d")
        self.datagram = self._whole
        """What to send after :meth:`seal`; overwritten by the next one."""
        self.values: Floats = np.frombuffer(plain, dtype="<f8", count=elements, offset=BODY.size)
        """Shape (elements,): fill before :meth:`seal`."""
        self._sealer = sealer
        self._stream = stream

    def fill(self, values: Sequence[float]) -> None:
        """Set all :attr:`values`; with cold caches at a fraction of what NumPy takes."""
        self._numbers.pack_into(self._plain, BODY.size, *values)

    def renew(self, sealer: Sealer) -> None:
        """Begin, or go on under a new session."""
        self._sealer = sealer

    def seal(
        self,
        tick: int,
        sent: int,
        *,
        echo_sent: int = 0,
        echo_received: int = 0,
        epoch: int = 0,
        acknowledged: tuple[int, int] = (0, -1),
        flags: int = 0,
        content: int | None = None,
    ) -> int:
        """Complete the packet of ``tick`` (times in ns) and return its sequence.

        ``acknowledged`` is a session of the other side and the highest sequence received under it,
        ``content`` the tick from which on the values have been the same (``tick`` without it).

        Raises:
            RuntimeError: there is no session yet.
        """
        if self._sealer is None:
            message = "a packet cannot be sealed before the handshake"
            raise RuntimeError(message)
        session, highest = acknowledged
        facts = (tick, sent, echo_sent, echo_received, epoch, highest, flags, session & LOW_HALF)
        plain, self.datagram = self._plain, self._whole
        if flags & PacketFlag.WITHHELD:
            plain, self.datagram = self._short_plain, self._short
            values = self.values
            self._short_numbers.pack_into(plain, BODY.size, *[values[i] for i in self._head])
        BODY.pack_into(plain, 0, *facts, tick if content is None else content)
        return self._sealer.seal(PacketKind.DATA, self._stream, plain, self.datagram)


class DataReader:
    """Opens the data packets of one stream; ``values`` is a view on the last one opened."""

    def __init__(
        self, opener: Opener, stream: int, elements: int, head: Sequence[int] = ()
    ) -> None:
        """``head`` has the elements that travel where the others are withheld."""
        self._stream = stream
        self.size = datagram_size(elements)
        plain = bytearray(self.size - HEADER.size - TAG_SIZE)
        self._plain = memoryview(plain)
        self.values: Floats = np.frombuffer(plain, dtype="<f8", count=elements, offset=BODY.size)
        self.content = self._plain[BODY.size :]
        """The bytes of :attr:`values`."""
        self.head = tuple(head)
        self.withheld_size = datagram_size(len(self.head))
        """Of a packet without content; such a one is opened into the head alone."""
        self._short = memoryview(bytearray(self.withheld_size - HEADER.size - TAG_SIZE))
        self._numbers = struct.Struct(f"<{len(self.head)}d")
        self.opener = opener

    def open(self, datagram: memoryview, sequence: int) -> tuple[int, ...] | None:
        """The nine members of :data:`BODY`, or ``None`` for a forgery.

        ``sequence`` is the header's, which the caller has read to know the session and stream.
        """
        plain = self._plain if len(datagram) == self.size else self._short
        if not self.opener.open_as(PacketKind.DATA, self._stream, sequence, datagram, plain):
            return None
        return BODY.unpack_from(plain)

    def complete(self, content: memoryview) -> None:
        """After a packet without content: what it withholds is ``content``, the head its own."""
        self.content[:] = content
        own = self._numbers.unpack_from(self._short, BODY.size)
        for place, value in zip(self.head, own, strict=True):
            self.values[place] = value
