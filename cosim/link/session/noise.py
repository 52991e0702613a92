"""``Noise_NNpsk0_25519_AESGCM_SHA256`` (The Noise Protocol Framework, revision 34), two messages.

::

    -> psk, e
    <- e, ee

Both ends hold a pre-shared key; fresh ephemeral keys give forward secrecy for all but the payload
of the first message. Primitives come from ``cryptography``; nothing here reads a clock or a socket.
"""

from __future__ import annotations

import hashlib
import hmac

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

NAME = b"Noise_NNpsk0_25519_AESGCM_SHA256"
KEY_SIZE = 32
TAG_SIZE = 16


class NoiseError(Exception):
    """A message that this handshake did not expect: another key, other words before it, a forgery.

    Never a user's mistake; whoever reads messages counts it.
    """


class NoiseHandshake:
    """One handshake; the initiator writes first, then reads, the responder the other way round."""

    def __init__(
        self, *, initiator: bool, psk: bytes, prologue: bytes, ephemeral: bytes | None = None
    ) -> None:
        """``psk`` has 32 bytes; ``ephemeral`` is the private key to use instead of a fresh one."""
        self._private = (
            X25519PrivateKey.generate()
            if ephemeral is None
            else X25519PrivateKey.from_private_bytes(ephemeral)
        )
        self.public = self._private.public_key().public_bytes_raw()
        """Own ephemeral public key, 32 bytes: what a message begins with."""
        self._writes_first = initiator
        # A name of exactly 32 bytes is its own hash (section 5.2).
        self._chain = NAME
        self.hash = NAME
        """Of everything said so far; after two messages it names the session."""
        self._key: AESGCM | None = None
        self._mix_hash(prologue)
        self._messages = 0
        self._remote = b""
        self._chain, mixed, key = _expand(self._chain, psk, 3)
        self._mix_hash(mixed)
        self._key = AESGCM(key)

    def write(self, payload: bytes) -> bytes:
        """The next own message: 32 bytes of ephemeral key, the payload, 16 bytes of tag."""
        self._expect(writes=True)
        self._mix_ephemeral(self.public)
        if self._messages == 1:
            self._mix_shared()
        assert self._key is not None
        sealed = self._key.encrypt(bytes(12), payload, self.hash)
        self._mix_hash(sealed)
        self._messages += 1
        return self.public + sealed

    def read(self, message: bytes) -> bytes:
        """The payload of the other side's next message.

        Raises:
            NoiseError: it is not that; the handshake cannot be used any more.
        """
        self._expect(writes=False)
        if len(message) < KEY_SIZE + TAG_SIZE:
            raise NoiseError("it is too short")
        self._remote, sealed = message[:KEY_SIZE], message[KEY_SIZE:]
        self._mix_ephemeral(self._remote)
        if self._messages == 1:
            self._mix_shared()
        assert self._key is not None
        try:
            payload = self._key.decrypt(bytes(12), sealed, self.hash)
        except InvalidTag:
            raise NoiseError("its seal is not of this handshake") from None
        self._mix_hash(sealed)
        self._messages += 1
        return payload

    def split(self) -> tuple[bytes, bytes]:
        """After both messages: the keys to send and to receive with, 32 bytes each."""
        if self._messages != 2:
            raise NoiseError("the handshake is not over")
        first, second = _expand(self._chain, b"", 2)
        return (first, second) if self._writes_first else (second, first)

    def _expect(self, *, writes: bool) -> None:
        own_turn = self._writes_first == (self._messages == 0)
        if self._messages > 1 or own_turn != writes:
            raise NoiseError("it is not this side's turn")

    def _mix_hash(self, content: bytes) -> None:
        self.hash = hashlib.sha256(self.hash + content).digest()

    def _mix_key(self, content: bytes) -> None:
        self._chain, key = _expand(self._chain, content, 2)
        self._key = AESGCM(key)

    def _mix_ephemeral(self, public: bytes) -> None:
        # With a pre-shared key an ephemeral key is mixed into the key, too (section 9.2).
        self._mix_hash(public)
        self._mix_key(public)

    def _mix_shared(self) -> None:
        try:
            shared = self._private.exchange(X25519PublicKey.from_public_bytes(self._remote))
        except ValueError:
            # A point of small order gives an all-zero secret that everybody knows.
            raise NoiseError("its ephemeral key is none") from None
        self._mix_key(shared)


def _expand(chain: bytes, content: bytes, count: int) -> list[bytes]:
    """Noise's HKDF (section 4.3): ``count`` keys of 32 bytes."""
    secret = hmac.digest(chain, content, "sha256")
    keys: list[bytes] = []
    last = b""
    for number in range(1, count + 1):
        last = hmac.digest(secret, last + bytes((number,)), "sha256")
        keys.append(last)
    return keys
