"""The side that is asked for sessions: the station whose name sorts first.

A HELLO makes a pending entry with a serial of its own; the first sealed packet under it confirms
it, if its serial is newer than the present session's. So replayed HELLOs make entries whose keys
nobody holds, and a packet that was kept back cannot bring an older session in. The present session
stays until then, and is read for a while longer.
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Callable
from dataclasses import dataclass

from cosim.link.session.contract import Contract
from cosim.link.session.greeting import (
    COOKIE_SIZE,
    Greeter,
    Greeting,
    Payload,
    question_of,
)
from cosim.link.session.keys import PreSharedKey, SessionKeys, prologue
from cosim.link.session.live import Keep, LiveSession, session_of
from cosim.link.session.noise import NoiseError, NoiseHandshake
from cosim.link.session.outcome import NOTHING, Drops, SessionOutcome
from cosim.link.session.refusal import ContractExchange, Refusal
from cosim.link.wire.packet import PacketKind

LARGEST_PENDING = 16
PENDING_LIFE = 5_000_000_000
"""ns after which an entry that nobody has confirmed is forgotten."""
PENDING_WITHOUT_COOKIE = 3
PREVIOUS_LIFE = 3_000_000_000
"""ns for which a session that was replaced is still read."""
SECRET_LIFE = 20_000_000_000
"""ns after which the cookies' secret changes; the one before is good as long."""
COSTLY_RATE = 100.0
"""Greetings a second that may cost key agreements; what can be answered by a look-up is free."""
COSTLY_BURST = 32.0
PRESENT_INTERVAL = 1_000_000_000
"""ns between two words of an answerer that nobody has asked yet."""


@dataclass(slots=True)
class _Pending:
    serial: int
    ephemeral: bytes
    reply: bytes
    live: LiveSession
    created: int


class Answerer:
    """One pair's answering side. Datagrams and times (ns) come in, datagrams go out."""

    asks = False

    def __init__(
        self,
        *,
        own: str,
        peer: str,
        key: PreSharedKey,
        contract: Contract,
        random: Callable[[int], bytes] = secrets.token_bytes,
        proof_of_address: bool = False,
    ) -> None:
        """``proof_of_address``: the first HELLO, too, is answered with a cookie alone."""
        self.own, self.peer = own, peer
        self.current: LiveSession | None = None
        self.previous: LiveSession | None = None
        self.busy = False
        """Refuse whoever fits, with that reason."""
        self.drops = Drops()
        self._greeter = Greeter(own=own, peer=peer, key=key)
        self._psk = key.derive("noise", context=prologue(own, peer))
        self._prologue = prologue(own, peer)
        self._random = random
        self.instance = int.from_bytes(random(8), "little")
        self._contracts = ContractExchange(contract, own=own, peer=peer, instance=self.instance)
        self._free_entries = 0 if proof_of_address else PENDING_WITHOUT_COOKIE
        self._pending: list[_Pending] = []
        self._confirmed = b""
        """The asker's ephemeral key of the present session."""
        self._serial = 0
        self._current_serial = 0
        self._previous_until = 0
        self._secrets = [random(32), random(32)]
        self._secret_since: int | None = None
        self._allowance = COSTLY_BURST
        self._allowed_at: int | None = None
        self._present_at: int | None = None

    @property
    def refusal(self) -> Refusal | None:
        """What is known of a peer that runs something else.

        It may come from a replayed question, so it is something to show and no reason to stop.
        """
        return self._contracts.refusal

    def poll(self, now: int) -> list[bytes]:
        """What to send at ``now`` without being asked."""
        self._forget_old(now)
        if self.current is not None:
            return []
        if self._present_at is not None and now - self._present_at < PRESENT_INTERVAL:
            return []
        self._present_at = now
        return [self._greeter.write(PacketKind.PRESENT, 0)]

    def receive(
        self, datagram: bytes, received: int, now: int, address: bytes = b""
    ) -> SessionOutcome:
        """Take a datagram that came from ``address`` at ``received``."""
        self._forget_old(now)
        session = session_of(datagram)
        if session is not None:
            return self._take_keep(session, datagram, received, now)
        greeting = self._greeter.read(datagram)
        if greeting is None:
            self.drops.foreign += 1
            self.drops.same_name += self._greeter.is_own(datagram)
            return NOTHING
        if greeting.kind is not PacketKind.HELLO:
            self.drops.stray += 1
            return NOTHING
        return SessionOutcome(answer=self._answer(greeting, now, address))

    def _answer(self, hello: Greeting, now: int, address: bytes) -> bytes | None:
        for pending in self._pending:
            if pending.ephemeral == hello.ephemeral:
                return pending.reply
        if hello.ephemeral == self._confirmed or question_of(hello.ephemeral) != hello.question:
            self.drops.stray += 1
            return None
        if len(self._pending) >= self._free_entries and not self._is_baked(hello, now, address):
            cookie = self._bake(self._secrets[0], hello, address)
            return self._greeter.write(PacketKind.COOKIE, hello.question, hello.ephemeral, cookie)
        if not self._may_cost(now):
            self.drops.too_many += 1
            return None
        return self._agree(hello, now)

    def _agree(self, hello: Greeting, now: int) -> bytes | None:
        noise = NoiseHandshake(
            initiator=False, psk=self._psk, prologue=self._prologue, ephemeral=self._random(32)
        )
        try:
            payload = Payload.unpack(noise.read(hello.noise))
            if payload is None or payload.busy:
                self.drops.foreign += 1
                return None
            fits = self._contracts.fits(payload)
            answer = self._contracts.payload(busy=fits and self.busy)
            message = noise.write(answer.pack())
        except NoiseError:
            self.drops.foreign += 1
            return None
        if not fits or self.busy:
            return self._greeter.write(PacketKind.REFUSE, hello.question, message)
        outgoing, incoming = noise.split()
        keys = SessionKeys(int.from_bytes(noise.hash[:8], "little"), outgoing, incoming)
        reply = self._greeter.write(PacketKind.REPLY, hello.question, message)
        self._serial += 1
        if len(self._pending) >= LARGEST_PENDING:
            self._pending.pop(0)
        live = LiveSession(keys, instance=payload.instance, now=now)
        self._pending.append(_Pending(self._serial, hello.ephemeral, reply, live, now))
        return reply

    def _take_keep(self, session: int, datagram: bytes, received: int, now: int) -> SessionOutcome:
        for live in (self.current, self.previous):
            if live is not None and live.keys.session == session:
                return self._judge(live, live.read(datagram, received, now))
        for pending in self._pending:
            if pending.live.keys.session != session:
                continue
            keep = pending.live.read(datagram, received, now)
            if keep is not None and pending.serial > self._current_serial:
                self._confirm(pending, now)
            return self._judge(pending.live, keep)
        self.drops.stray += 1
        return NOTHING

    def _judge(self, live: LiveSession, keep: Keep | None) -> SessionOutcome:
        if keep is None or live is not self.current:
            # Of the previous session: it is read, but says nothing of the present.
            self.drops.stray += 1
            return NOTHING
        return SessionOutcome(keep=keep)

    def _confirm(self, pending: _Pending, now: int) -> None:
        self.previous, self._previous_until = self.current, now + PREVIOUS_LIFE
        self.current = pending.live
        self._current_serial = pending.serial
        self._confirmed = pending.ephemeral
        self._contracts.refusal = None
        self._pending = [entry for entry in self._pending if entry.serial > pending.serial]

    def _forget_old(self, now: int) -> None:
        if self._pending and now - self._pending[0].created > PENDING_LIFE:
            self._pending = [p for p in self._pending if now - p.created <= PENDING_LIFE]
        if self.previous is not None and now > self._previous_until:
            self.previous = None

    def _bake(self, secret: bytes, hello: Greeting, address: bytes) -> bytes:
        return hmac.digest(secret, hello.ephemeral + address, "sha256")[:COOKIE_SIZE]

    def _is_baked(self, hello: Greeting, now: int, address: bytes) -> bool:
        since = self._secret_since
        if since is None or now - since > SECRET_LIFE:
            stale = since is None or now - since > 2 * SECRET_LIFE
            self._secrets = [self._random(32), self._random(32) if stale else self._secrets[0]]
            self._secret_since = now
        return any(
            hmac.compare_digest(hello.cookie, self._bake(secret, hello, address))
            for secret in self._secrets
        )

    def _may_cost(self, now: int) -> bool:
        passed = 0 if self._allowed_at is None else max(0, now - self._allowed_at)
        self._allowed_at = now
        self._allowance = min(COSTLY_BURST, self._allowance + passed * 1e-9 * COSTLY_RATE)
        if self._allowance < 1.0:
            return False
        self._allowance -= 1.0
        return True
