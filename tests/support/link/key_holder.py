"""Who holds the session's keys and sends what he likes: authentic packets with absurd contents."""

from __future__ import annotations

import random

import numpy as np

from cosim.link.session.keys import SessionKeys
from cosim.link.session.live import KEEP_SIZE
from cosim.link.wire.packet import BODY, HEADER, TAG_SIZE, PacketKind, Sealer, datagram_size

EXTREMES = [0, 1, -1, 2**31, -(2**31), 2**53, 2**60, 2**60 + 1, 2**62, 2**63 - 1, -(2**63)]
NUMBERS = [0.0, -0.0, 1.0, 0.1, -0.1, 1e300, -1e308, float("inf"), float("-inf"), float("nan")]


class KeyHolder:
    """Speaks with a station's keys, from a place in the sequences that the station never reached.

    ``values`` are what an honest station would send; ``None`` stands for the tick.
    """

    def __init__(
        self, keys: SessionKeys, values: list[float | None], epoch: int, seed: int
    ) -> None:
        self.draw = random.Random(seed)
        self.values, self.epoch = values, epoch
        self.data = self.keeps = 0
        """Packets made, by kind."""
        self.sealer = Sealer(keys.outgoing, keys.session)
        for kind in (PacketKind.DATA, PacketKind.KEEP):
            self.sealer._next[kind << 16] = 1_000_000

    def integer(self) -> int:
        draw = self.draw
        return draw.choice(EXTREMES) if draw.random() < 0.7 else draw.randrange(-(2**63), 2**63)

    def number(self) -> float:
        draw = self.draw
        if draw.random() < 0.7:
            return draw.choice(NUMBERS)
        return float(np.frombuffer(draw.randbytes(8), "<f8")[0])

    def datagram(self, tick: int, now: int) -> bytes:
        """A packet that is authentic and absurd, sometimes in one place only."""
        draw = self.draw
        is_keep = draw.random() < 0.2
        kind = PacketKind.KEEP if is_keep else PacketKind.DATA
        self.keeps += is_keep
        self.data += not is_keep
        size = KEEP_SIZE if is_keep else datagram_size(len(self.values))
        plain = bytearray(draw.randbytes(size - HEADER.size - TAG_SIZE))
        if not is_keep:
            self._fill(plain, tick, now)
        elif draw.random() < 0.8:
            numbers = [self.integer() for _ in range(4)]
            plain[:32] = b"".join(n.to_bytes(8, "little", signed=True) for n in numbers)
            plain[32:] = bytes([draw.randrange(8), *bytes(7)])
        slot = kind << 16
        if draw.random() < 0.01:
            before, self.sealer._next[slot] = self.sealer._next[slot], draw.randrange(2**63, 2**64)
            datagram = self._seal(kind, plain, size)
            self.sealer._next[slot] = before
            return datagram
        return self._seal(kind, plain, size)

    def _fill(self, plain: bytearray, tick: int, now: int) -> None:
        draw = self.draw
        facts = [tick, now, 0, 0, self.epoch, -1]
        values = [float(tick) if value is None else value for value in self.values]
        for place in range(6):
            if draw.random() < 0.1:
                facts[place] = self.integer()
        # As many of four as of forty: about one packet in three is honest in all its values.
        for place in range(len(values)):
            if draw.random() < 1.2 / len(values):
                values[place] = self.number()
        flags = draw.choice([0, 0, 1, 2, 3, 4, 2**32 - 1])
        content = tick if draw.random() < 0.9 else self.integer()
        BODY.pack_into(plain, 0, *facts, flags, draw.getrandbits(32), content)
        np.frombuffer(plain, "<f8", len(values), BODY.size)[:] = values

    def _seal(self, kind: PacketKind, plain: bytearray, size: int) -> bytes:
        datagram = bytearray(size)
        self.sealer.seal(kind, 0, memoryview(plain), memoryview(datagram))
        return bytes(datagram)
