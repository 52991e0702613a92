"""Who holds the key may send what he likes, who does not as much as he likes: all is counted."""

from __future__ import annotations

import random

import numpy as np
import pytest

from cosim.link.stream.fate import Fate
from cosim.link.wire.packet import HEADER, PacketKind
from tests.support.link.bounds import check_records
from tests.support.link.key_holder import KeyHolder
from tests.support.link.whole import MILLISECOND, SECOND, Wire, World

WAY = 2 * MILLISECOND


def passing(_source: str, _target: str, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
    return [(now + WAY, datagram)]


def met() -> World:
    world = World(Wire(passing), ["a", "b"])
    for name in world.names:
        world.start(name)
    world.run(4 * SECOND)
    assert world.weights() == [1.0, 1.0]
    return world


@pytest.mark.parametrize("count", [5_000, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", ["a", "b"])
def test_absurd_contents_under_the_right_key_are_counted(name: str, count: int) -> None:
    world = met()
    other = world.stations["b" if name == "a" else "a"]
    keys = world.stations[name].process.links[0].session
    values = [0.1, None, 0.0, 11.0]
    holder = KeyHolder(keys, values, other.process.links[0].peer_epoch, 7)
    world.kill(name)
    world.run(world.wire.now + 20 * MILLISECOND)
    link = other.process.links[0]
    receiver = link.incoming[0].receiver
    before = sum(receiver.tally) - receiver.tally[Fate.SUPERSEDED]
    side = other.negotiator.side(0)
    wire = world.wire
    while holder.data + holder.keeps < count:
        for _ in range(25):
            tick = other.tick + other.grid.first_tick
            wire.put(wire.now + MILLISECOND, name, other.name, holder.datagram(tick, 0))
        world.run(wire.now + 8 * MILLISECOND)
    world.run(wire.now + 50 * MILLISECOND)
    assert link.faulty == other.process.absurd == 0
    after = sum(receiver.tally) - receiver.tally[Fate.SUPERSEDED]
    assert after - before == holder.data
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
