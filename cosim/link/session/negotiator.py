"""All that a station's handshake process decides, without sockets: fed with bytes and times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.link.session.answerer import Answerer
from cosim.link.session.asker import Asker
from cosim.link.session.contract import Contract
from cosim.link.session.keys import NO_KEY, PreSharedKey, SessionKeys, read_key_file
from cosim.link.session.messages import OFFER, PATH, START, USE, refusal
from cosim.link.session.start import EXCHANGES, Side, StartAgreement

SideFactory = type[Asker] | type[Answerer]


def side_of(own: str, peer: str, key: PreSharedKey, contract: Contract) -> Side:
    """The own side of a pair: the station whose name sorts second asks, so two never ask."""
    kind: SideFactory = Asker if own > peer else Answerer
    return kind(own=own, peer=peer, key=key, contract=contract)


class SessionNegotiator:
    """Sessions with every peer and the start; :meth:`news` says what the loop has to know."""

    def __init__(self, settings: Mapping[str, Any]) -> None:
        """Of ``settings``: own, peers, key_files, contracts (by peer), tick, period.

        Raises:
            InputError: a key file cannot be used.
        """
        self.peers: list[str] = settings["peers"]
        files: list[str | None] = settings["key_files"]
        keys = [NO_KEY if file is None else read_key_file(Path(file)) for file in files]
        sides = {
            peer: side_of(settings["own"], peer, key, Contract(contract))
            for peer, key, contract in zip(self.peers, keys, settings["contracts"], strict=True)
        }
        self.agreement = StartAgreement(
            own=settings["own"],
            sides=sides,
            tick=Fraction(settings["tick"]),
            period=settings["period"],
            exchanges=settings.get("exchanges", EXCHANGES),
        )
        self.agreement.armed = False
        self._offered: dict[str, list[tuple[int, int]]] = {peer: [] for peer in self.peers}
        self._used: dict[str, int] = {}
        self._measured: dict[str, int] = {}
        self._refused: dict[str, int] = {}
        self._started = False

    def side(self, number: int) -> Side:
        """The handshake with a peer by its number."""
        return self.agreement.side(self.peers[number])

    def hear_of(self, alive: Sequence[int], now: int) -> None:
        """Of every peer, the session under which data come and are acknowledged; 0 for none."""
        for number, session in enumerate(alive):
            current = self.side(number).current
            if current is not None and current.keys.session == session:
                current.heard = current.acknowledged = now

    def news(self) -> list[bytes]:
        """Messages for the loop about what has changed."""
        out: list[bytes] = []
        for number, peer in enumerate(self.peers):
            out += self._keys(number, peer)
            out += self._path(number, peer)
            found = self.agreement.side(peer).refusal
            if found is not None and self._refused.get(peer) != hash(found):
                self._refused[peer] = hash(found)
                out.append(refusal(peer, found.differences))
        start = self.agreement.start
        if start is not None and not self._started:
            self._started = True
            out.append(START.pack(b"G", start.epoch, start.first_tick))
        return out

    def facts(self) -> dict[str, Any]:
        """What the manifest tells of the handshakes; never a key."""
        found: dict[str, Any] = {"absurd_grids": self.agreement.absurd}
        for peer in self.peers:
            found[peer] = {
                **asdict(self.agreement.side(peer).drops),
                "absurd_exchanges": self.agreement.clock(peer).refused,
            }
        return found

    def _keys(self, number: int, peer: str) -> list[bytes]:
        side, out = self.agreement.side(peer), list[bytes]()
        offered = self._offered[peer]
        candidate = side.candidate if isinstance(side, Asker) else None
        for live in (candidate, side.current):
            if live is None or any(session == live.keys.session for session, _ in offered):
                continue
            same = bool(offered) and offered[-1][1] == live.instance
            offered.append((live.keys.session, live.instance))
            del offered[:-4]
            out.append(_offer(number, live.keys, same=same))
        current = side.current
        if current is not None and self._used.get(peer) != current.keys.session:
            self._used[peer] = current.keys.session
            out.append(USE.pack(b"U", number, current.keys.session))
        return out

    def _path(self, number: int, peer: str) -> list[bytes]:
        """Once a session: how long packets take to and from the peer."""
        current, clock = self.agreement.side(peer).current, self.agreement.clock(peer)
        known = clock.ready and clock.samples >= EXCHANGES
        if current is None or not known or self._measured.get(peer) == current.keys.session:
            return []
        self._measured[peer] = current.keys.session
        return [PATH.pack(b"A", number, clock.round_trip, clock.incoming(0.9))]


def _offer(number: int, keys: SessionKeys, *, same: bool) -> bytes:
    return OFFER.pack(b"O", number, same, keys.session, keys.outgoing, keys.incoming)
