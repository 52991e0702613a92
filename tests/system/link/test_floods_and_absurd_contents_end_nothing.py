"""Who holds the key may send what he likes, who does not as much as he likes: all is counted."""

from __future__ import annotations

import random

import numpy as np
import pytest

from cosim.link.session.live import KEEP_SIZE
from cosim.link.stream.receiver import Fate
from cosim.link.wire.packet import BODY, HEADER, TAG_SIZE, PacketKind, Sealer, datagram_size
from tests.support.link.bounds import check_records
from tests.support.link.whole import MILLISECOND, SECOND, Station, Wire, World

WAY = 2 * MILLISECOND
EXTREMES = [0, 1, -1, 2**31, -(2**31), 2**53, 2**60, 2**60 + 1, 2**62, 2**63 - 1, -(2**63)]
NUMBERS = [0.0, -0.0, 1.0, 0.1, -0.1, 1e300, -1e308, float("inf"), float("-inf"), float("nan")]


def passing(_source: str, _target: str, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
    return [(now + WAY, datagram)]


def met() -> World:
    world = World(Wire(passing), ["a", "b"])
    for name in world.names:
        world.start(name)
    world.run(4 * SECOND)
    assert world.weights() == [1.0, 1.0]
    return world


class KeyHolder:
    """Takes over where station ``name`` was, with its keys and its place in the sequences."""

    def __init__(self, station: Station, epoch: int, seed: int) -> None:
        self.draw = random.Random(seed)
        self.epoch = epoch
        keys = station.process.links[0].session
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
        size = KEEP_SIZE if is_keep else datagram_size(4)
        plain = bytearray(draw.randbytes(size - HEADER.size - TAG_SIZE))
        if not is_keep:
            facts = [tick, now, 0, 0, self.epoch, -1]
            values = [0.1, float(tick), 0.0, 11.0]
            for place in range(6):
                if draw.random() < 0.1:
                    facts[place] = self.integer()
            for place in range(4):
                if draw.random() < 0.3:
                    values[place] = self.number()
            flags = draw.choice([0, 0, 1, 2, 3, 2**32 - 1])
            BODY.pack_into(plain, 0, *facts, flags, draw.getrandbits(32))
            np.frombuffer(plain, "<f8", 4, BODY.size)[:] = values
        elif draw.random() < 0.8:
            numbers = [self.integer() for _ in range(4)]
            plain[:32] = b"".join(n.to_bytes(8, "little", signed=True) for n in numbers)
        slot = kind << 16
        if draw.random() < 0.01:
            before, self.sealer._next[slot] = self.sealer._next[slot], draw.randrange(2**63, 2**64)
            datagram = self._seal(kind, plain, size)
            self.sealer._next[slot] = before
            return datagram
        return self._seal(kind, plain, size)

    def _seal(self, kind: PacketKind, plain: bytearray, size: int) -> bytes:
        datagram = bytearray(size)
        self.sealer.seal(kind, 0, memoryview(plain), memoryview(datagram))
        return bytes(datagram)


@pytest.mark.parametrize("count", [5_000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["a", "b"])
def test_absurd_contents_under_the_right_key_are_counted(name: str, count: int) -> None:
    world = met()
    other = world.stations["b" if name == "a" else "a"]
    holder = KeyHolder(world.stations[name], other.process.links[0].peer_epoch, 7)
    world.kill(name)
    world.run(world.wire.now + 20 * MILLISECOND)
    link = other.process.links[0]
    receiver = link.incoming[0].receiver
    before = sum(receiver.tally) - receiver.tally[Fate.SUPERSEDED]
    side = other.negotiator.side(0)
    wire, sent, keeps = world.wire, 0, 0
    while sent < count:
        for _ in range(25):
            tick = other.tick + other.grid.first_tick
            datagram = holder.datagram(tick, 0)
            keeps += datagram[3] == PacketKind.KEEP
            wire.put(wire.now + MILLISECOND, name, other.name, datagram)
            sent += 1
        world.run(wire.now + 8 * MILLISECOND)
    world.run(wire.now + 50 * MILLISECOND)
    assert link.faulty == other.process.absurd == 0
    after = sum(receiver.tally) - receiver.tally[Fate.SUPERSEDED]
    assert after - before == sent - keeps
    for fate in (Fate.ABSURD, Fate.LATE, Fate.OUT_OF_RANGE, Fate.ACCEPTED):
        assert receiver.tally[fate] > count // 50, fate
    assert side.drops.total > 0
    assert all(abs(sample.value) <= 1.0 for sample in other.samples[name])
    weights = [sample.weight for sample in other.samples[name]]
    steps = np.diff(weights[weights.index(1.0) :])
    assert steps.max() <= 1.001 / 128
    assert steps.min() >= -1.001 / 7
    # And the honest one comes back.
    world.start(name)
    world.run(wire.now + 6 * SECOND)
    assert world.agreed()
    assert world.weights() == [1.0, 1.0]


@pytest.mark.parametrize("kind", ["junk", "short junk", "replay", "greetings", "mixed"])
@pytest.mark.parametrize("name", ["a", "b"])
def test_a_flood_at_twenty_times_the_rate_keeps_no_restarted_peer_out(name: str, kind: str) -> None:
    world = met()
    draw = random.Random(3)
    recorded: list[tuple[str, str, bytes]] = []
    wire = world.wire

    def record(source: str, target: str, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        recorded.append((source, target, datagram))
        return passing(source, target, datagram, now)

    wire.treat = record
    world.kill(name)
    world.start(name)
    world.run(wire.now + 5 * SECOND)
    assert world.agreed()
    kept = list(recorded)
    greetings = [item for item in kept if PacketKind.HELLO <= item[2][3] <= PacketKind.COOKIE]
    assert greetings

    def flood() -> None:
        for _ in range(10):
            chosen = draw.choice(["junk", "short junk", "replay", "greetings"])
            match kind if kind != "mixed" else chosen:
                case "junk":
                    head = HEADER.pack(b"cH", 2, draw.choice([16, 17, 18]), 0, 0, 5, 0)
                    source, target = draw.choice([("a", "b"), ("b", "a")])
                    content = head + draw.randbytes(1176)
                case "short junk":
                    source, target = draw.choice([("a", "b"), ("b", "a")])
                    content = draw.randbytes(80)
                case "replay":
                    source, target, content = draw.choice(kept)
                case _:
                    source, target, content = draw.choice(greetings)
            wire.put(wire.now + MILLISECOND, source, target, content)

    begin, end = wire.now, wire.now + 8 * SECOND
    events = [(at, flood) for at in range(begin, end, 4 * MILLISECOND)]
    at = begin + SECOND
    events += [(at, lambda: world.kill(name)), (at, lambda: world.start(name))]
    wire.treat = passing
    world.run(at + 3 * SECOND, events)
    assert world.agreed()
    assert world.stations[name].running
    world.run(at + 5 * SECOND)
    assert world.weights() == [1.0, 1.0]
    check_records(world)
