"""The side that asks for sessions: the station whose name sorts second.

Whenever nothing new was heard, or nothing acknowledged, for a second, it asks for another session;
the present one goes on until the first packet has come under the new one.
"""

from __future__ import annotations

import secrets
from collections.abc import Callable

from cosim.link.session.contract import Contract
from cosim.link.session.greeting import NO_COOKIE, Greeter, Greeting, Payload, question_of
from cosim.link.session.keys import PreSharedKey, SessionKeys, prologue
from cosim.link.session.live import LiveSession, SessionState, session_of
from cosim.link.session.noise import NoiseError, NoiseHandshake
from cosim.link.session.outcome import NOTHING, Drops, SessionOutcome
from cosim.link.session.refusal import ContractExchange, Refusal
from cosim.link.wire.packet import PacketKind

RETRY = 50_000_000
"""ns between two sendings of the same question."""
SILENCE = 1_000_000_000
"""ns without a first copy, or without an acknowledgement, after which a session is asked for."""


class Asker:
    """One pair's asking side. Datagrams and times (ns) come in, datagrams go out."""

    asks = True

    def __init__(
        self,
        *,
        own: str,
        peer: str,
        key: PreSharedKey,
        contract: Contract,
        random: Callable[[int], bytes] = secrets.token_bytes,
    ) -> None:
        self.own, self.peer = own, peer
        self.current: LiveSession | None = None
        self.previous: LiveSession | None = None
        self.candidate: LiveSession | None = None
        """Agreed on, but nothing has come under it yet."""
        self.drops = Drops()
        self.busy = False
        """The other side has said that it serves somebody else."""
        self._greeter = Greeter(own=own, peer=peer, key=key)
        self._psk = key.derive("noise", context=prologue(own, peer))
        self._prologue = prologue(own, peer)
        self._random = random
        self.instance = int.from_bytes(random(8), "little")
        self._contracts = ContractExchange(contract, own=own, peer=peer, instance=self.instance)
        self._noise: NoiseHandshake | None = None
        self._hello = b""
        """The Noise message of the present question; written once, for its nonce is used up."""
        self._cookie = NO_COOKIE
        self._asked_at: int | None = None
        self._candidate_since = 0

    @property
    def refusal(self) -> Refusal | None:
        """How the peer's contract differs, once that is known."""
        return self._contracts.refusal

    def poll(self, now: int) -> list[bytes]:
        """What to send at ``now`` without being asked."""
        current, candidate = self.current, self.candidate
        if candidate is not None:
            if now - self._candidate_since <= SILENCE:
                due = candidate.is_due(now, RETRY)
                return [candidate.write(now, 0, SessionState.NONE)] if due else []
            self._ask()
        elif self._noise is None and (
            current is None or now - min(current.heard, current.acknowledged) > SILENCE
        ):
            self._ask()
        if self._noise is None or (self._asked_at is not None and now - self._asked_at < RETRY):
            return []
        self._asked_at = now
        return [self._question()]

    def receive(
        self, datagram: bytes, received: int, now: int, address: bytes = b""
    ) -> SessionOutcome:
        """Take a datagram that came at ``received``; ``address`` is the answerer's to look at."""
        del address
        session = session_of(datagram)
        if session is not None:
            return self._take_keep(session, datagram, received, now)
        greeting = self._greeter.read(datagram)
        if greeting is None:
            self.drops.foreign += 1
            self.drops.same_name += self._greeter.is_own(datagram)
            return NOTHING
        if greeting.kind is PacketKind.PRESENT:
            return NOTHING
        noise = self._noise
        if noise is None or greeting.question != question_of(noise.public):
            self.drops.stray += 1
            return NOTHING
        match greeting.kind:
            case PacketKind.COOKIE if greeting.ephemeral == noise.public:
                return self._take_cookie(greeting, now)
            case PacketKind.REPLY | PacketKind.REFUSE:
                return self._take_answer(greeting, noise, now)
            case _:
                self.drops.stray += 1
                return NOTHING

    def _ask(self) -> None:
        self.candidate = None
        noise = NoiseHandshake(
            initiator=True, psk=self._psk, prologue=self._prologue, ephemeral=self._random(32)
        )
        self._hello = noise.write(self._contracts.payload().pack())
        self._noise = noise
        self._cookie = NO_COOKIE
        self._asked_at = None

    def _question(self) -> bytes:
        assert self._noise is not None
        question = question_of(self._noise.public)
        return self._greeter.write(PacketKind.HELLO, question, self._hello, self._cookie)

    def _take_cookie(self, greeting: Greeting, now: int) -> SessionOutcome:
        if greeting.cookie == self._cookie:
            return NOTHING
        # At once, but the same cookie never twice: two sides must not play ball.
        self._cookie = greeting.cookie
        self._asked_at = now
        return SessionOutcome(answer=self._question())

    def _take_answer(self, greeting: Greeting, noise: NoiseHandshake, now: int) -> SessionOutcome:
        try:
            payload = Payload.unpack(noise.read(greeting.noise))
        except NoiseError:
            payload = None
        refuses = greeting.kind is PacketKind.REFUSE
        if payload is None or (payload.busy and not refuses):
            # Authentic, and yet it does not answer: the handshake's state is spent.
            self.drops.stray += 1
            self._ask()
            return NOTHING
        fits = self._contracts.fits(payload)
        if not fits or refuses:
            self.busy = payload.busy
            self._ask()
            self._asked_at = now
            return NOTHING
        self.busy = False
        outgoing, incoming = noise.split()
        keys = SessionKeys(int.from_bytes(noise.hash[:8], "little"), outgoing, incoming)
        self._noise = None
        self.candidate = LiveSession(keys, instance=payload.instance, now=now)
        self._candidate_since = now
        return SessionOutcome(answer=self.candidate.write(now, 0, SessionState.NONE))

    def _take_keep(self, session: int, datagram: bytes, received: int, now: int) -> SessionOutcome:
        candidate = self.candidate
        if candidate is not None and candidate.keys.session == session:
            keep = candidate.read(datagram, received, now)
            if keep is not None:
                self._switch(candidate)
                return SessionOutcome(keep=keep)
        current = self.current
        if current is not None and current.keys.session == session:
            keep = current.read(datagram, received, now)
            if keep is not None:
                return SessionOutcome(keep=keep)
        self.drops.stray += 1
        return NOTHING

    def _switch(self, candidate: LiveSession) -> None:
        self.previous, self.current, self.candidate = self.current, candidate, None
        self._contracts.refusal = None
