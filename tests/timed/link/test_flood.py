"""A flood changes nothing: it is counted, bounded in every tick, and does not starve the peer."""

from __future__ import annotations

import itertools
import random
import sys

import pytest

from cosim.link.stream.fate import Fate
from cosim.link.wire.packet import HEADER, DataWriter, PacketKind, Sealer
from tests.support.link.lockstep import UdpWorld
from tests.support.link.support import OTHER_KEY, both_ends

pytestmark = pytest.mark.skipif(
    sys.platform != "linux", reason="what the kernel drops is counted on Linux"
)

TICK_NS = 1e9 / 1024
SAMPLE_NS = 8 * TICK_NS


class Flood:
    """Passes each packet after a tick, and adds ``a_tick`` others before and after it."""

    def __init__(self, kind: str, a_tick: float) -> None:
        self.kind = kind
        self.count = round(8 * a_tick)
        self.packets: list[bytes] = []
        self.sent = 0
        self.peer = lambda datagram: datagram
        """What comes in place of the peer's own packet."""
        self.draw = random.Random(1)
        other, _ = both_ends(OTHER_KEY)
        self.writer = DataWriter(Sealer(other.outgoing, other.session), 0, 4)

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        self.packets.append(datagram)
        flood = [
            (now + round((0.5 + number / self.count * 8) * TICK_NS), self.datagram())
            for number in range(self.count if self.packets[16:] else 0)
        ]
        self.sent += len(flood)
        # At one instant the flood comes first: what is thrown away is then the peer's packet.
        own = (now + round(1.4 * TICK_NS), self.peer(datagram))
        return sorted([*flood, own], key=lambda item: item[0])

    def datagram(self) -> bytes:
        newest = self.packets[-1]
        match self.kind:
            case "foreign":
                self.writer.seal(len(self.packets) * 8, 1)
                return bytes(self.writer.datagram)
            case "replayed":
                return self.draw.choice(self.packets[:-1])
            case "copies":
                return newest
            case "handshakes":
                return (
                    newest[:3]
                    + bytes([self.draw.randrange(PacketKind.HELLO, PacketKind.KEEP + 1)])
                    + (self.draw.randbytes(1196))
                )
            case "long":
                return bytes(60_000)
            case "forged":
                sequence = HEADER.unpack_from(newest)[-1] + self.draw.randrange(1, 1000)
                return newest[:16] + sequence.to_bytes(8, "little") + newest[24:]
            case "mixed":
                self.kind = self.draw.choice(["foreign", "replayed", "long", "handshakes"])
                try:
                    return self.datagram()
                finally:
                    self.kind = "mixed"
        raise ValueError(self.kind)


class Pass:
    def __init__(self) -> None:
        self.packets: list[bytes] = []

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        self.packets.append(datagram)
        return [(now + round(TICK_NS), datagram)]


@pytest.mark.parametrize(
    ("kind", "a_tick"),
    [
        # 20 times the packet rate is two and a half datagrams a tick.
        *((kind, 2.5) for kind in ("foreign", "replayed", "copies", "handshakes", "forged")),
        ("long", 2.5),
        # As much as a loop ever reads; whoever sees the session can do no more than this for free.
        ("forged", 30.0),
        # A hundred times that, and more than the socket's queue holds in a tick.
        ("foreign", 100.0),
        ("replayed", 100.0),
        ("mixed", 100.0),
        ("foreign", 400.0),
    ],
)
def test_a_flood_neither_starves_the_peer_nor_lengthens_a_tick(kind: str, a_tick: float) -> None:
    flood = Flood(kind, a_tick)
    samples = 100 if a_tick < 50 else 50 if a_tick < 200 else 32
    read: list[int] = []
    weights: list[float] = []
    with UdpWorld(flood, Pass()) as world:
        link = world.b.link
        receiver = link.incoming[0].receiver

        def watch(station, tick: int) -> None:
            looked_at = sum(receiver.tally) - receiver.tally[Fate.SUPERSEDED]
            read.append(looked_at + link.foreign + len(station.forwarded))
            weights.append(station.value("lan.weight"))

        world.b.watch = watch
        world.run(8 * samples)
        dropped = world.transports[1].dropped_by_kernel
        accepted = receiver.tally[Fate.ACCEPTED]
        unread = world.proxy.release(world.transports[1].now + 10**10)[0]
    assert flood.sent >= 8 * a_tick * (samples - 17)
    # Everything is somewhere: looked at, thrown away unread, dropped by the kernel, on its way.
    assert read[-1] + link.intake.flood + dropped + unread == flood.sent + len(flood.packets)
    assert max(b - a for a, b in itertools.pairwise(read)) <= link.intake.reads
    # The flood's first tick of a second may cost the peer's packet, which is one of 128.
    assert samples - 2 <= accepted <= samples
    assert weights[-1] == 1.0
    assert min(weights[weights.index(1.0) :]) == 1.0


def test_a_flood_that_ends_leaves_no_filter_behind() -> None:
    flood = Flood("foreign", 100.0)
    with UdpWorld(flood, Pass()) as world:
        world.run(8 * 30)
        flood.count = 0
        world.run(8 * 140)
        dropped = world.transports[1].dropped_by_kernel
        foreign = world.b.link.incoming[0].receiver.tally[Fate.FOREIGN]
        flood.count = 8
        world.run(8 * 20)
        assert world.transports[1].dropped_by_kernel == dropped
        again = world.b.link.incoming[0].receiver.tally[Fate.FOREIGN] - foreign
    assert 8 * 19 <= again <= 8 * 20


def test_a_peer_that_restarts_is_heard_while_the_flood_goes_on() -> None:
    """Handshakes are kept out only as long as the peer counts."""
    flood = Flood("foreign", 80.0)
    with UdpWorld(flood, Pass()) as world:
        world.run(8 * 40)
        flood.peer = lambda datagram: datagram[:3] + bytes([PacketKind.HELLO]) + bytes(1196)
        heard = len(world.b.forwarded)
        world.run(8 * 10)
        assert len(world.b.forwarded) - heard <= 1
        world.run(8 * 130)
        assert world.b.value("lan.weight") == 0.0
        assert len(world.b.forwarded) - heard > 10


KINDS = ("forged", "replayed", "truncated", "foreign")


@pytest.mark.parametrize("count", [3_200, pytest.param(100_000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("kind", KINDS)
def test_many_bad_packets_through_a_socket_change_nothing(kind: str, count: int) -> None:
    batch = 32
    genuine = Pass()
    with UdpWorld(genuine, Pass()) as world:
        world.run(8 * 300)
        kept = genuine.packets
        link, transport = world.b.link, world.transports[1]
        receiver = link.incoming[0].receiver
        other, _ = both_ends(OTHER_KEY)
        writer = DataWriter(Sealer(other.outgoing, other.session), 0, 4)
        writer.seal(2400, 1)
        forged = bytearray(kept[-1])
        forged[30] ^= 1
        bad = {
            "forged": [bytes(forged)],
            "replayed": kept[:128],
            "truncated": [kept[-1][:-1], kept[-1][:24], kept[-1] + b"."],
            "foreign": [bytes(writer.datagram)],
        }[kind]
        receiver.release(2400)
        highest = receiver.highest(link.session.session)
        held = (receiver.tick, receiver.sequence, highest, receiver.values.tobytes())
        before = receiver.counts
        for number in range(count // batch):
            for place in range(batch):
                world.proxy.send(bad[(number * batch + place) % len(bad)], is_forward=True)
            transport.expected += batch
            link.drain(2400)
        changed = receiver.counts - before
        assert changed[Fate[kind.upper()]] == changed.sum() == count
        assert not receiver.release(2408)
        assert held == (
            receiver.tick,
            receiver.sequence,
            receiver.highest(link.session.session),
            receiver.values.tobytes(),
        )
        assert (link.intake.flood, link.foreign, transport.dropped_by_kernel) == (0, 0, 0)
        world.run(16)
        assert receiver.tick > held[0]
