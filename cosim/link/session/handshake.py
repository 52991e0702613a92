"""Three messages that agree on a session: HELLO, REPLY, CONFIRM (and an acknowledgement).

The station whose name sorts second asks, the other one answers; so two never ask at once. Nothing
here reads a clock or a socket: datagrams and times come in, datagrams go out.

Every message before the session exists carries an HMAC-SHA256 under a key that the pre-shared key
derives for this pair and direction (a reflected message fails), has one size (no reply is larger
than what asked for it), and carries a piece of the sender's contract, so that a refusal can show
the difference. The answering side keeps no state for a HELLO: its nonce is a function of the
asker's nonce and of a secret that changes, so replayed HELLOs neither cost memory nor push out an
honest one. A session that lives is kept until the CONFIRM of a new one has come, which only the
holder of the key and of both fresh nonces can write.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets
import struct
from collections.abc import Callable
from dataclasses import dataclass

from cosim.link.session.contract import Contract
from cosim.link.session.keys import PreSharedKey, SessionKeys, session_keys
from cosim.link.wire.packet import HEADER, MAGIC, VERSION, Kind

MESSAGE_SIZE = 1200
NONCE_SIZE = 32
MAC_SIZE = 32
_BODY = struct.Struct("<32s32s32s32sHHH2x")
"""own nonce, peer nonce, contract hash, confirmation, piece, pieces, piece length."""
_PIECE_SIZE = MESSAGE_SIZE - HEADER.size - _BODY.size - MAC_SIZE
_LARGEST_PIECES = 4096
RETRY = 50_000_000
"""ns between two sendings of the same question."""
CONFIRM_TRIES = 20
"""CONFIRMs without an answer after which the asking side begins anew."""
SECRET_LIFE = 20_000_000_000
"""ns after which the answering side renews its nonce secret; the one before is good as long."""


@dataclass(frozen=True, slots=True)
class Refusal:
    """The peer is who it says, but its contract differs; ``differences`` are sentences."""

    peer: str
    differences: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Message:
    kind: Kind
    own_nonce: bytes
    peer_nonce: bytes
    contract_hash: bytes
    confirmation: bytes
    piece: int
    pieces: int
    data: bytes


class Handshake:
    """One pair's handshake, for as long as the station runs.

    ``session`` is the newest confirmed session. ``refusal`` is set once the peer's contract is
    known to differ; on the answering side it may come from a replayed question, so there it is
    something to show and no reason to stop. ``nonce`` makes fresh nonces (injected by tests).
    """

    def __init__(
        self,
        *,
        own: str,
        peer: str,
        key: PreSharedKey,
        contract: Contract,
        nonce: Callable[[], bytes] = lambda: secrets.token_bytes(NONCE_SIZE),
    ) -> None:
        self.own = own
        self.peer = peer
        self.asks = own > peer
        self.session: SessionKeys | None = None
        self.refusal: Refusal | None = None
        self.dropped = 0
        """Datagrams that were not authentic or made no sense."""
        self._contract = contract
        self._packed = contract.packed()
        self._key = key
        names = "\0".join(sorted((own, peer))).encode()
        self._mac_out = key.derive(f"greeting {own}", context=names)
        self._mac_in = key.derive(f"greeting {peer}", context=names)
        self._make_nonce = nonce
        self._pieces_of = b""
        self._pieces: dict[int, bytes] = {}
        self._sent = 0
        # Asking side.
        self._asking = self.asks
        self._own_nonce = nonce()
        self._candidate: SessionKeys | None = None
        self._confirm: bytes | None = None
        self._last_sent: int | None = None
        self._tries = 0
        # Answering side.
        self._secrets = [nonce(), nonce()]
        self._secret_since: int | None = None
        self._used: dict[bytes, int] = {}

    def ask_again(self) -> None:
        """Look for a new session (the peer fell silent); the present one stays until then."""
        if self.asks and not self._asking:
            self._ask()
            self._last_sent = None

    @property
    def settled(self) -> bool:
        """Whether this side has nothing to ask."""
        return self.session is not None and not self._asking

    def poll(self, now: int) -> bytes | None:
        """What to send at ``now`` (ns), if anything."""
        if not self._asking:
            return None
        if self._last_sent is not None and now - self._last_sent < RETRY:
            return None
        self._last_sent = now
        if self._confirm is not None:
            self._tries += 1
            if self._tries <= CONFIRM_TRIES:
                return self._confirm
            self._ask()
        return self._message(Kind.HELLO, self._own_nonce, bytes(NONCE_SIZE))

    def receive(self, datagram: bytes, now: int) -> bytes | None:
        """Take a datagram; what to answer, if anything."""
        message = self._read(datagram)
        if message is None:
            self.dropped += 1
            return None
        match message.kind, self.asks:
            case Kind.HELLO, False:
                return self._answer_hello(message, now)
            case Kind.CONFIRM, False:
                return self._answer_confirm(message, now)
            case Kind.REPLY, True:
                return self._answer_reply(message, now)
            case Kind.ACKNOWLEDGE, True:
                return self._take_acknowledgement(message)
            case Kind.REFUSE, _:
                # Only as an answer to the present question, so that an old one cannot refuse us.
                if self._asking and message.peer_nonce == self._own_nonce:
                    self._compare(message)
                return None
            case _:
                self.dropped += 1
                return None

    # The side that asks.

    def _ask(self) -> None:
        self._asking = True
        self._own_nonce = self._make_nonce()
        self._candidate = None
        self._confirm = None

    def _answer_reply(self, message: _Message, now: int) -> bytes | None:
        if not self._asking or message.peer_nonce != self._own_nonce:
            return None
        keys = self._session_keys(message.own_nonce)
        if not self._confirms(message, keys, self.peer):
            self.dropped += 1
            return None
        self._candidate = keys
        self._tries = 0
        self._confirm = self._message(
            Kind.CONFIRM,
            self._own_nonce,
            message.own_nonce,
            confirmation=_confirmation(keys, self.own),
        )
        self._last_sent = now
        return self._confirm

    def _take_acknowledgement(self, message: _Message) -> None:
        candidate = self._candidate
        if not self._asking or candidate is None or message.peer_nonce != self._own_nonce:
            return
        expected = _confirmation(candidate, "acknowledge " + self.peer)
        if not hmac.compare_digest(message.confirmation, expected):
            self.dropped += 1
            return
        self.session = candidate
        self.refusal = None
        self._asking = False
        self._candidate = None
        self._confirm = None

    # The side that answers.

    def _answer_hello(self, message: _Message, now: int) -> bytes | None:
        if message.contract_hash != self._contract.hash:
            self._compare(message)
            return self._message(Kind.REFUSE, self._make_nonce(), message.own_nonce)
        nonce = self._nonce_for(message.own_nonce, self._current_secret(now))
        keys = self._session_keys(message.own_nonce, own_nonce=nonce)
        return self._message(
            Kind.REPLY,
            nonce,
            message.own_nonce,
            confirmation=_confirmation(keys, self.own),
        )

    def _answer_confirm(self, message: _Message, now: int) -> bytes | None:
        self._current_secret(now)
        fresh = any(
            hmac.compare_digest(message.peer_nonce, self._nonce_for(message.own_nonce, secret))
            for secret in self._secrets
        )
        if not fresh:
            self.dropped += 1
            return None
        keys = self._session_keys(message.own_nonce, own_nonce=message.peer_nonce)
        if not self._confirms(message, keys, self.peer):
            self.dropped += 1
            return None
        if self.session is None or keys.session != self.session.session:
            # A session that was replaced must not come back: its sequences would repeat.
            if message.peer_nonce in self._used:
                self.dropped += 1
                return None
            self._used[message.peer_nonce] = now
            self.session = keys
            self.refusal = None
        return self._message(
            Kind.ACKNOWLEDGE,
            message.peer_nonce,
            message.own_nonce,
            confirmation=_confirmation(keys, "acknowledge " + self.own),
        )

    def _current_secret(self, now: int) -> bytes:
        age = None if self._secret_since is None else now - self._secret_since
        if age is None or age > SECRET_LIFE:
            previous = self._secrets[0]
            if age is None or age > 2 * SECRET_LIFE:
                previous = self._make_nonce()
            self._secrets = [self._make_nonce(), previous]
            self._secret_since = now
            # A secret is good for less than four lives; what it confirmed is kept for longer, or
            # an old CONFIRM could bring a session back whose sequences would repeat.
            self._used = {
                nonce: at for nonce, at in self._used.items() if now - at <= 5 * SECRET_LIFE
            }
        return self._secrets[0]

    def _nonce_for(self, peer_nonce: bytes, secret: bytes) -> bytes:
        return hmac.digest(secret, peer_nonce, "sha256")

    # Both.

    def _session_keys(self, peer_nonce: bytes, own_nonce: bytes | None = None) -> SessionKeys:
        return session_keys(
            self._key,
            own=self.own,
            peer=self.peer,
            own_nonce=own_nonce or self._own_nonce,
            peer_nonce=peer_nonce,
            contract=self._contract.hash,
        )

    def _confirms(self, message: _Message, keys: SessionKeys, sender: str) -> bool:
        return message.contract_hash == self._contract.hash and hmac.compare_digest(
            message.confirmation, _confirmation(keys, sender)
        )

    def _compare(self, message: _Message) -> None:
        """Collect the peer's contract; once it is whole, say how it differs."""
        if message.contract_hash == self._contract.hash:
            return
        if self._pieces_of != message.contract_hash:
            self._pieces_of = message.contract_hash
            self._pieces.clear()
        self._pieces[message.piece] = message.data
        if len(self._pieces) < message.pieces:
            return
        packed = b"".join(self._pieces[number] for number in sorted(self._pieces))
        differences = self._contract.difference(Contract.unpack(packed), self.own, self.peer)
        self._pieces.clear()
        self.refusal = Refusal(self.peer, tuple(differences))

    def _message(
        self, kind: Kind, own_nonce: bytes, peer_nonce: bytes, *, confirmation: bytes = bytes(32)
    ) -> bytes:
        pieces = max(1, -(-len(self._packed) // _PIECE_SIZE))
        piece = self._sent % pieces
        self._sent += 1
        data = self._packed[piece * _PIECE_SIZE : (piece + 1) * _PIECE_SIZE]
        message = bytearray(MESSAGE_SIZE)
        HEADER.pack_into(message, 0, MAGIC, VERSION, kind, 0, 0, 0, self._sent)
        _BODY.pack_into(
            message,
            HEADER.size,
            own_nonce,
            peer_nonce,
            self._contract.hash,
            confirmation,
            piece,
            pieces,
            len(data),
        )
        start = HEADER.size + _BODY.size
        message[start : start + len(data)] = data
        message[-MAC_SIZE:] = hmac.digest(self._mac_out, bytes(message[:-MAC_SIZE]), hashlib.sha256)
        return bytes(message)

    def _read(self, datagram: bytes) -> _Message | None:
        if len(datagram) != MESSAGE_SIZE:
            return None
        magic, version, kind, *_ = HEADER.unpack_from(datagram)
        if magic != MAGIC or version != VERSION or kind not in _HANDSHAKE_KINDS:
            return None
        mac = hmac.digest(self._mac_in, datagram[:-MAC_SIZE], hashlib.sha256)
        if not hmac.compare_digest(mac, datagram[-MAC_SIZE:]):
            return None
        own, peer, contract_hash, confirmation, piece, pieces, length = _BODY.unpack_from(
            datagram, HEADER.size
        )
        if piece >= pieces or pieces > _LARGEST_PIECES or length > _PIECE_SIZE:
            return None
        start = HEADER.size + _BODY.size
        data = datagram[start : start + length]
        return _Message(Kind(kind), own, peer, contract_hash, confirmation, piece, pieces, data)


_HANDSHAKE_KINDS = frozenset(
    {
        Kind.HELLO,
        Kind.REPLY,
        Kind.CONFIRM,
        Kind.ACKNOWLEDGE,
        Kind.REFUSE,
    }
)


def _confirmation(keys: SessionKeys, words: str) -> bytes:
    """Proof of having come to the same session keys, 32 bytes."""
    return hmac.digest(keys.confirmation, words.encode(), "sha256")
