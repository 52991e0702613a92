"""The datagrams of a handshake as bytes: who greets, an HMAC over all, and what Noise sealed.

HELLO, REPLY and REFUSE have one size, so no answer is larger than its question. The HMAC under a
key of this pair and direction is looked at first: junk costs one hash, and a message that is sent
back to its sender fails.
"""

from __future__ import annotations

import hmac
import struct
from dataclasses import dataclass

from cosim.link.session.keys import PreSharedKey, join
from cosim.link.session.noise import KEY_SIZE, TAG_SIZE
from cosim.link.wire.packet import HEADER, MAGIC, VERSION, PacketKind

GREETING_SIZE = 1200
COOKIE_SIZE = 16
MAC_SIZE = 32
PAYLOAD_SIZE = GREETING_SIZE - HEADER.size - KEY_SIZE - COOKIE_SIZE - TAG_SIZE - MAC_SIZE
_COOKIE_AT = HEADER.size + KEY_SIZE
_NOISE_AT = _COOKIE_AT + COOKIE_SIZE
_PAYLOAD = struct.Struct("<32sQHHHH")
"""contract hash, instance, piece, pieces, length, reason."""
PIECE_SIZE = PAYLOAD_SIZE - _PAYLOAD.size
SIZES: dict[int, int] = {
    PacketKind.HELLO: GREETING_SIZE,
    PacketKind.REPLY: GREETING_SIZE,
    PacketKind.REFUSE: GREETING_SIZE,
    PacketKind.COOKIE: HEADER.size + KEY_SIZE + COOKIE_SIZE + MAC_SIZE,
    PacketKind.PRESENT: HEADER.size + MAC_SIZE,
}
"""Bytes of a datagram of each kind of greeting."""
NO_COOKIE = bytes(COOKIE_SIZE)


@dataclass(frozen=True, slots=True)
class Payload:
    """What HELLO, REPLY and REFUSE say inside the seal."""

    contract: bytes
    """Hash, 32 bytes."""
    instance: int
    """Drawn at random when the station started: tells a restart from a renewal."""
    piece: int
    pieces: int
    data: bytes
    """Piece ``piece`` of ``pieces`` (from 0, at least one) of the packed contract."""
    busy: bool = False
    """Of a REFUSE: the contract fits, but this side serves somebody else."""

    def pack(self) -> bytes:
        """:data:`PAYLOAD_SIZE` bytes."""
        facts = (self.contract, self.instance, self.piece, self.pieces, len(self.data), self.busy)
        return (_PAYLOAD.pack(*facts) + self.data).ljust(PAYLOAD_SIZE, b"\0")

    @classmethod
    def unpack(cls, content: bytes) -> Payload | None:
        """What was packed, or ``None`` where it makes no sense."""
        if len(content) != PAYLOAD_SIZE:
            return None
        contract, instance, piece, pieces, length, reason = _PAYLOAD.unpack_from(content)
        if piece >= pieces or length > PIECE_SIZE or reason > 1:
            return None
        data, rest = content[_PAYLOAD.size :][:length], content[_PAYLOAD.size + length :]
        if any(rest):
            return None
        return cls(contract, instance, piece, pieces, data, busy=reason == 1)


@dataclass(frozen=True, slots=True)
class Greeting:
    """An authentic datagram of a handshake."""

    kind: PacketKind
    question: int
    """Names the HELLO that it is or answers: the first 8 bytes of the asker's ephemeral key."""
    ephemeral: bytes = b""
    cookie: bytes = NO_COOKIE
    sealed: bytes = b""
    """The rest of the Noise message after the ephemeral key."""

    @property
    def noise(self) -> bytes:
        """The whole Noise message."""
        return self.ephemeral + self.sealed


class Greeter:
    """Writes and reads the greetings between two named stations."""

    def __init__(self, *, own: str, peer: str, key: PreSharedKey) -> None:
        names = join(*(name.encode() for name in sorted((own, peer))))
        self._mac_out = key.derive(f"greeting {own}", context=names)
        self._mac_in = key.derive(f"greeting {peer}", context=names)

    def write(
        self, kind: PacketKind, question: int, noise: bytes = b"", cookie: bytes = NO_COOKIE
    ) -> bytes:
        """A datagram. ``noise`` is the Noise message, of a COOKIE the asker's ephemeral key."""
        head = HEADER.pack(MAGIC, VERSION, kind, 0, 0, question, 0)
        body = b"" if kind is PacketKind.PRESENT else noise[:KEY_SIZE] + cookie + noise[KEY_SIZE:]
        return head + body + hmac.digest(self._mac_out, head + body, "sha256")

    def read(self, datagram: bytes) -> Greeting | None:
        """What an authentic datagram says; ``None`` for anything else."""
        if not _has_form(datagram) or not self._is_sealed_with(self._mac_in, datagram):
            return None
        kind, question = PacketKind(datagram[3]), HEADER.unpack_from(datagram)[5]
        if kind is PacketKind.PRESENT:
            return None if question else Greeting(kind, question)
        body = datagram[:-MAC_SIZE]
        return Greeting(
            kind,
            question,
            body[HEADER.size : _COOKIE_AT],
            body[_COOKIE_AT:_NOISE_AT],
            body[_NOISE_AT:],
        )

    def is_own(self, datagram: bytes) -> bool:
        """Whether it is what this side itself would write: the other one has the same name."""
        return _has_form(datagram) and self._is_sealed_with(self._mac_out, datagram)

    @staticmethod
    def _is_sealed_with(key: bytes, datagram: bytes) -> bool:
        mac = hmac.digest(key, datagram[:-MAC_SIZE], "sha256")
        return hmac.compare_digest(mac, datagram[-MAC_SIZE:])


def question_of(ephemeral: bytes) -> int:
    """The number that names a HELLO in clear."""
    return int.from_bytes(ephemeral[:8], "little")


def _has_form(datagram: bytes) -> bool:
    if len(datagram) < HEADER.size or len(datagram) != SIZES.get(datagram[3]):
        return False
    magic, version, _, stream, zero, _, sequence = HEADER.unpack_from(datagram)
    return (magic, version, stream, zero, sequence) == (MAGIC, VERSION, 0, 0, 0)
