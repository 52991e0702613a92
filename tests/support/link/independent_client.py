"""Another program at the link: written from docs/protocol.md alone, importing nothing of ours.

It is the asking side (its name sorts second), follows the start of the other one, sends a value at
every sample and takes those that come.
"""

from __future__ import annotations

import base64
import hashlib
import hmac
import json
import math
import os
import struct
import zlib

from cryptography.exceptions import InvalidTag
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey
from cryptography.hazmat.primitives.ciphers.aead import AESGCM

VERSION = 2
DATA, HELLO, REPLY, REFUSE, COOKIE, PRESENT, KEEP = 1, 16, 17, 18, 19, 20, 21
READY, GRID, RUNNING = 1, 2, 4
WITHHELD = 4
SECOND = 10**9
MILLISECOND = 10**6
NEVER = -(1 << 62)


def lengths(*parts: bytes) -> bytes:
    return b"".join(struct.pack("<I", len(part)) + part for part in parts)


def hkdf(secret: bytes, info: bytes) -> bytes:
    """RFC 5869 without salt, one block."""
    extracted = hmac.new(bytes(32), secret, hashlib.sha256).digest()
    return hmac.new(extracted, info + b"\x01", hashlib.sha256).digest()


def read_key_line(line: str) -> bytes:
    name, _, text = line.strip().partition(" ")
    assert name == "cohaptic-key-1"
    secret = base64.b64decode(text)
    assert len(secret) == 32
    assert any(secret)
    return secret


def header(kind: int, session: int = 0, sequence: int = 0, stream: int = 0) -> bytes:
    return struct.pack("<2sBBHHQQ", b"cH", VERSION, kind, stream, 0, session, sequence)


class Noise:
    """The initiator of Noise_NNpsk0_25519_AESGCM_SHA256."""

    def __init__(self, psk: bytes, prologue: bytes) -> None:
        self.h = self.ck = b"Noise_NNpsk0_25519_AESGCM_SHA256"
        self.mix_hash(prologue)
        self.ck, mixed, self.k = self.expand(psk, 3)
        self.mix_hash(mixed)
        self.private = X25519PrivateKey.generate()
        self.public = self.private.public_key().public_bytes_raw()

    def expand(self, content: bytes, count: int) -> list[bytes]:
        secret = hmac.new(self.ck, content, hashlib.sha256).digest()
        out, last = [], b""
        for number in range(1, count + 1):
            last = hmac.new(secret, last + bytes([number]), hashlib.sha256).digest()
            out.append(last)
        return out

    def mix_hash(self, content: bytes) -> None:
        self.h = hashlib.sha256(self.h + content).digest()

    def mix_key(self, content: bytes) -> None:
        self.ck, self.k = self.expand(content, 2)

    def first(self, payload: bytes) -> bytes:
        self.mix_hash(self.public)
        self.mix_key(self.public)
        sealed = AESGCM(self.k).encrypt(bytes(12), payload, self.h)
        self.mix_hash(sealed)
        return self.public + sealed

    def second(self, message: bytes) -> bytes:
        remote, sealed = message[:32], message[32:]
        self.mix_hash(remote)
        self.mix_key(remote)
        self.mix_key(self.private.exchange(X25519PublicKey.from_public_bytes(remote)))
        payload = AESGCM(self.k).decrypt(bytes(12), sealed, self.h)
        self.mix_hash(sealed)
        return payload

    def split(self) -> tuple[bytes, bytes]:
        first, second = self.expand(b"", 2)
        return first, second


class Session:
    def __init__(self, number: int, out_key: bytes, in_key: bytes) -> None:
        self.number = number
        self.out, self.inward = AESGCM(out_key), AESGCM(in_key)
        self.next: dict[tuple[int, int], int] = {}
        self.seen: dict[tuple[int, int], set[int]] = {}
        self.keep_echo = (0, 0)
        self.keep_sent = NEVER
        self.highest = -1

    def seal(self, kind: int, body: bytes, stream: int = 0) -> bytes:
        sequence = self.next.get((kind, stream), 0)
        self.next[kind, stream] = sequence + 1
        head = header(kind, self.number, sequence, stream)
        return head + self.out.encrypt(struct.pack("<BBHQ", kind, 0, stream, sequence), body, head)

    def open(self, datagram: bytes) -> bytes | None:
        """The body of a first copy."""
        _, _, kind, stream, _, _, sequence = struct.unpack_from("<2sBBHHQQ", datagram)
        nonce = struct.pack("<BBHQ", kind, 0, stream, sequence)
        try:
            body = self.inward.decrypt(nonce, datagram[24:], datagram[:24])
        except InvalidTag:
            return None
        seen = self.seen.setdefault((kind, stream), set())
        if sequence in seen or sequence <= max(seen, default=-1) - 128:
            return None
        seen.add(sequence)
        if kind == DATA:
            self.highest = max(self.highest, sequence)
        return body


class Client:
    def __init__(
        self, own: str, peer: str, key: bytes, contract: dict, *, rate: int, values: int
    ) -> None:
        assert own > peer, "this one only asks"
        first, second = sorted((own.encode(), peer.encode()))
        version = bytes([VERSION])
        self.prologue = lengths(b"cohaptic link", version, first, second)

        def derive(purpose: bytes, context: bytes) -> bytes:
            return hkdf(key, lengths(b"cohaptic link", version, purpose, context))

        self.mac_out = derive(b"greeting " + own.encode(), lengths(first, second))
        self.mac_in = derive(b"greeting " + peer.encode(), lengths(first, second))
        self.psk = derive(b"noise", self.prologue)
        text = json.dumps(contract, separators=(",", ":"), ensure_ascii=False).encode()
        self.contract = hashlib.sha256(text).digest()
        packed = zlib.compress(text)
        self.pieces = [packed[i : i + 1032] for i in range(0, len(packed), 1032)]
        self.piece = 0
        self.instance = int.from_bytes(os.urandom(8), "little")
        self.tick_ns = SECOND / rate
        self.count = values
        self.noise: Noise | None = None
        self.hello = self.cookie = b""
        self.asked = NEVER
        self.present: Session | None = None
        self.candidate: Session | None = None
        self.candidate_since = 0
        self.heard = self.acknowledged = NEVER
        self.exchanges: list[tuple[int, int]] = []
        """Round trip and offset (peer less own clock)."""
        self.epoch: int | None = None
        self.tick: int | None = None
        self.data_echo = (0, 0)
        self.values: tuple[float, ...] = ()
        self.head: tuple[int, ...] = (1, 2, 3)
        """Places of the source's tick, age and status."""
        self.content: tuple[int, tuple[float, ...]] = (-1, ())
        self.withheld = 0
        self.shown_tick = -1
        self.their_contract: dict[int, bytes] = {}

    # The handshake.

    def ask(self) -> None:
        self.noise, self.candidate = Noise(self.psk, self.prologue), None
        data = self.pieces[self.piece % len(self.pieces)]
        payload = struct.pack(
            "<32sQHHHH",
            self.contract,
            self.instance,
            self.piece % len(self.pieces),
            len(self.pieces),
            len(data),
            0,
        )
        self.piece += 1
        self.hello = self.noise.first((payload + data).ljust(1080, b"\0"))
        self.cookie = bytes(16)
        self.asked = NEVER

    def question(self) -> int:
        return int.from_bytes(self.noise.public[:8], "little")

    def write_hello(self) -> bytes:
        content = header(HELLO, self.question()) + self.hello[:32] + self.cookie + self.hello[32:]
        return content + hmac.new(self.mac_out, content, hashlib.sha256).digest()

    def greeting(self, datagram: bytes, now: int) -> list[bytes]:
        mac = hmac.new(self.mac_in, datagram[:-32], hashlib.sha256).digest()
        if not hmac.compare_digest(mac, datagram[-32:]) or self.noise is None:
            return []
        kind, question = datagram[3], int.from_bytes(datagram[8:16], "little")
        if question != self.question():
            return []
        if kind == COOKIE and len(datagram) == 104 and datagram[24:56] == self.noise.public:
            self.cookie, self.asked = datagram[56:72], now
            return [self.write_hello()]
        if kind not in {REPLY, REFUSE} or len(datagram) != 1200:
            return []
        payload = self.noise.second(datagram[24:56] + datagram[72:-32])
        _, _, piece, pieces, length, _ = struct.unpack_from("<32sQHHHH", payload)
        if kind == REFUSE:
            self.their_contract[piece] = payload[48 : 48 + length]
            if len(self.their_contract) == pieces:
                packed = b"".join(self.their_contract[i] for i in range(pieces))
                self.their_text = zlib.decompress(packed)
            self.ask()
            self.asked = now
            return []
        mine, theirs = self.noise.split()
        session = int.from_bytes(self.noise.h[:8], "little")
        self.noise = None
        self.candidate = Session(session, mine, theirs)
        self.candidate_since = now
        return [self.keep(self.candidate, now)]

    # Keeps, clock and start.

    def keep(self, session: Session, now: int) -> bytes:
        session.keep_sent = now
        state = READY if len(self.exchanges) >= 16 else 0
        if self.epoch is not None:
            state |= GRID
        if self.tick is not None:
            state |= RUNNING
        body = struct.pack("<qqqqII", now, *session.keep_echo, self.epoch or 0, state, 0)
        return session.seal(KEEP, body)

    def take_keep(self, session: Session, datagram: bytes, now: int) -> None:
        body = session.open(datagram)
        if body is None:
            return
        if session is self.candidate:
            self.present, self.candidate = session, None
            self.acknowledged = now
        sent, echo_sent, echo_received, epoch, state, _ = struct.unpack("<qqqqII", body)
        session.keep_echo = (sent, now)
        self.heard = now
        self.peer_runs = bool(state & RUNNING)
        if echo_sent:
            self.acknowledged = max(self.acknowledged, echo_sent)
            trip = (now - echo_sent) - (sent - echo_received)
            self.exchanges.append((trip, ((echo_received - echo_sent) + (sent - now)) // 2))
        if state & GRID and self.epoch is None and len(self.exchanges) >= 16:
            _, offset = min(self.exchanges)
            self.epoch = epoch - offset
            past = now + (SECOND if state & RUNNING else 0) - self.epoch
            self.first_tick = max(0, math.ceil(past / self.tick_ns))

    # Values.

    def take_values(self, session: Session, datagram: bytes, now: int) -> None:
        body = session.open(datagram)
        if body is None:
            return
        if session is self.candidate:
            self.present, self.candidate = session, None
            self.acknowledged = now
        self.heard = now
        tick, sent, _, _, _, _, flags, _, content = struct.unpack_from("<qqqqqqIIq", body)
        self.data_echo = (sent, now)
        if flags & WITHHELD:
            head = iter(struct.unpack_from(f"<{len(self.head)}d", body, 64))
            if content != self.content[0]:
                return
            values = tuple(
                next(head) if place in self.head else value
                for place, value in enumerate(self.content[1])
            )
            self.withheld += 1
        else:
            values = struct.unpack_from(f"<{self.count}d", body, 64)
            if content < tick:
                self.content = (content, values)
        if all(math.isfinite(value) for value in values) and tick >= self.shown_tick:
            self.values, self.shown_tick = values, tick

    def data(self, values: tuple[float, ...], now: int, flags: int = 0) -> bytes:
        highest = self.present.highest
        tick = self.first_tick if self.tick is None else self.tick
        body = struct.pack(
            "<qqqqqqIIq",
            tick,
            now,
            *self.data_echo,
            self.epoch,
            highest,
            flags,
            self.present.number & 0xFFFFFFFF if highest >= 0 else 0,
            tick,
        )
        body += struct.pack(f"<{self.count}d", *values)
        return self.present.seal(DATA, body)

    # What it does.

    def receive(self, datagram: bytes, now: int) -> list[bytes]:
        if len(datagram) < 24 or datagram[:3] != b"cH" + bytes([VERSION]):
            return []
        kind, number = datagram[3], int.from_bytes(datagram[8:16], "little")
        if kind not in {KEEP, DATA}:
            return self.greeting(datagram, now)
        for session in (self.present, self.candidate):
            if session is not None and session.number == number:
                take = self.take_keep if kind == KEEP else self.take_values
                take(session, datagram, now)
        return []

    def poll(self, now: int) -> list[bytes]:
        out = []
        quiet = now - min(self.heard, self.acknowledged)
        if self.candidate is not None and now - self.candidate_since > SECOND:
            self.ask()
        wants = self.present is None or quiet > SECOND
        if self.noise is None and self.candidate is None and wants:
            self.ask()
        if self.noise is not None and now - self.asked >= 50 * MILLISECOND:
            self.asked = now
            out.append(self.write_hello())
        if self.candidate is not None and now - self.candidate.keep_sent >= 50 * MILLISECOND:
            out.append(self.keep(self.candidate, now))
        present = self.present
        if present is not None:
            calm = self.tick is not None and self.peer_runs
            if now - present.keep_sent >= (250 if calm else 20) * MILLISECOND:
                out.append(self.keep(present, now))
        return out

    def deadline(self) -> int | None:
        """When the next own tick is due (own clock)."""
        if self.epoch is None:
            return None
        tick = self.first_tick if self.tick is None else self.tick + 1
        return self.epoch + round(tick * self.tick_ns)

    def run_tick(self, values: tuple[float, ...], now: int) -> list[bytes]:
        self.tick = self.first_tick if self.tick is None else self.tick + 1
        return [self.data((values[0], float(self.tick), *values[2:]), now)] if self.present else []
