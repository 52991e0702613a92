"""A peer that runs something else: its contract comes piece by piece, and is shown, never used."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.link.session.contract import Contract
from cosim.link.session.greeting import PIECE_SIZE, Payload

LARGEST_PIECES = 1024


@dataclass(frozen=True, slots=True)
class Refusal:
    """The peer is who it says, but its contract differs; ``differences`` are sentences."""

    peer: str
    differences: tuple[str, ...]


class ContractExchange:
    """The own contract in pieces, and the peer's as far as it has come."""

    def __init__(self, contract: Contract, *, own: str, peer: str, instance: int) -> None:
        self.refusal: Refusal | None = None
        self._contract, self._own, self._peer = contract, own, peer
        self._instance = instance
        packed = contract.packed()
        self._pieces = [packed[at : at + PIECE_SIZE] for at in range(0, len(packed), PIECE_SIZE)]
        self._sent = 0
        self._of = b""
        self._collected: dict[int, bytes] = {}

    def payload(self, *, busy: bool = False) -> Payload:
        """What the own side says, each time with the next piece."""
        piece = self._sent % len(self._pieces)
        self._sent += 1
        return Payload(
            self._contract.hash,
            self._instance,
            piece,
            len(self._pieces),
            self._pieces[piece],
            busy=busy,
        )

    def fits(self, payload: Payload) -> bool:
        """Whether the peer runs the same; where it does not, its piece is kept to say how."""
        if payload.contract == self._contract.hash:
            return True
        if payload.pieces > LARGEST_PIECES:
            return False
        if self._of != payload.contract:
            self._of = payload.contract
            self._collected.clear()
        self._collected[payload.piece] = payload.data
        if len(self._collected) >= payload.pieces:
            packed = b"".join(self._collected[number] for number in sorted(self._collected))
            self._collected.clear()
            difference = self._contract.difference(Contract.unpack(packed), self._own, self._peer)
            self.refusal = Refusal(self._peer, tuple(difference))
        return False
