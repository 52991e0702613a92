"""Over real sockets, every counter of a receiver equals what a proxy on the way has injected."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from cosim.link.stream.fate import Fate
from cosim.link.wire.packet import DataWriter, Sealer, datagram_size
from cosim.link.wire.window import WINDOW
from cosim.testing.impairment import BadNetwork, Impairer
from tests.support.link.lockstep import TOO_LONG, UdpWorld
from tests.support.link.support import OTHER_KEY, both_ends
from tests.support.link.world import ACTIVE_STATUS

TICK_NS = 1e9 / 1024
SAMPLE_NS = 8 * TICK_NS
STALL = 10
"""Samples that a stall keeps back, all released at once."""

# What one packet that is treated so adds to the counters; "kernel", "unknown" and "passed on" are
# those outside of the receiver.
EFFECT: dict[str, dict] = {
    "pass": {Fate.ACCEPTED: 1},
    "lose": {},
    "copy": {Fate.ACCEPTED: 1, Fate.DUPLICATE: 1},
    "late copy": {Fate.ACCEPTED: 1, Fate.DUPLICATE: 1},
    "two copies": {Fate.ACCEPTED: 1, Fate.DUPLICATE: 2},
    "replay": {Fate.ACCEPTED: 1, Fate.REPLAYED: 1},
    "keep back": {Fate.REORDERED: 1},
    "flip sequence": {Fate.FORGED: 1},
    "flip body": {Fate.FORGED: 1},
    "flip tag": {Fate.FORGED: 1},
    "flip magic": {Fate.FOREIGN: 1},
    "flip version": {Fate.FOREIGN: 1},
    "flip session": {Fate.FOREIGN: 1},
    "flip zero": {Fate.FOREIGN: 1},
    "flip stream": {"unknown": 1},
    "another kind": {"unknown": 1},
    "a handshake's kind": {"passed on": 1},
    "cut": {Fate.TRUNCATED: 1},
    "cut to a head": {Fate.FORGED: 1},
    "cut in the header": {Fate.TRUNCATED: 1},
    "nothing left": {Fate.TRUNCATED: 1},
    "lengthen": {Fate.TRUNCATED: 1},
    "too long": {"kernel": 1},
    "other key": {Fate.ACCEPTED: 1, Fate.FOREIGN: 1},
    "other key, our session": {Fate.ACCEPTED: 1, Fate.FORGED: 1},
    "out of range": {Fate.OUT_OF_RANGE: 1},
    "jump": {Fate.JUMP: 1},
    # Ten samples come with the one after them: older than the link's five is late, and of the rest
    # the newest is shown, which is that next one.
    "stall": {Fate.LATE: 6, Fate.ACCEPTED: 4, Fate.SUPERSEDED: 4},
}
PLACES = {"magic": (0, 2), "version": (2, 3), "stream": (4, 6), "zero": (6, 8), "session": (8, 16)}


def plan(seed: int, rounds: int) -> list[str]:
    """What is done to each packet; three untouched ones after each that is treated."""
    draw = random.Random(seed)
    treatments = [name for name in EFFECT for _ in range(rounds)]
    draw.shuffle(treatments)
    actions = ["pass"] * 3
    for name in treatments:
        actions += [f"stall {n}" for n in range(STALL)] if name == "stall" else [name]
        actions += ["pass"] * 3
    return actions


def expected(actions: list[str]) -> Counter:
    found: Counter = Counter()
    for action in actions:
        name, _, number = action.partition(" ")
        effect = EFFECT["stall"] if name == "stall" else EFFECT[action]
        if name != "stall" or number == "0":
            found.update(effect)
    return found


class Treatment:
    """Does to each packet of one direction what the plan says."""

    def __init__(self, actions: list[str], seed: int) -> None:
        self.actions = actions
        self.number = 0
        self.draw = random.Random(seed)
        self.foreign: dict[str, DataWriter] = {}
        self.head_size = 0
        """Of a packet that withholds its content: one that is cut to it fails by its tag."""

    def take(self, datagram: bytes, now: int) -> list[tuple[int, bytes]]:
        if self.number >= len(self.actions):
            return [(now, datagram)]
        action = self.actions[self.number]
        self.number += 1
        soon = now + round(TICK_NS)
        match action.split():
            case ["lose"]:
                return []
            case ["copy"]:
                return [(soon, datagram), (soon + round(2 * TICK_NS), datagram)]
            case ["late", "copy"]:
                return [(soon, datagram), (soon + round(25 * SAMPLE_NS), datagram)]
            case ["two", "copies"]:
                return [(soon, datagram)] * 3
            case ["replay"]:
                return [(soon, datagram), (soon + round((WINDOW + 20) * SAMPLE_NS), datagram)]
            case ["keep", "back"]:
                return [(now + round(2.5 * SAMPLE_NS), datagram)]
            case ["stall", number]:
                return [(soon + round((STALL - int(number)) * SAMPLE_NS), datagram)]
            case ["other", "key,", *_]:
                return [(soon, datagram), (soon, self.sealed_elsewhere("our session"))]
            case ["other", "key"]:
                return [(soon, datagram), (soon, self.sealed_elsewhere("its session"))]
            case _:
                return [(soon, self.changed(action, datagram))]

    def sealed_elsewhere(self, which: str) -> bytes:
        writer = self.foreign[which]
        writer.seal(self.number * 8, 1)
        return bytes(writer.datagram)

    def changed(self, action: str, datagram: bytes) -> bytes:
        size, randrange = len(datagram), self.draw.randrange
        match action.split():
            case ["flip", where]:
                places = PLACES | {"sequence": (16, 24), "body": (24, size - 16)}
                first, end = (places | {"tag": (size - 16, size)})[where]
                changed = bytearray(datagram)
                changed[randrange(first, end)] ^= 1 << randrange(8)
                return bytes(changed)
            case ["another", "kind"]:
                kind = self.draw.choice([0, 2, 15, 22, 32, 33, 255])
                return datagram[:3] + bytes([kind]) + datagram[4:]
            case ["a", "handshake's", "kind"]:
                return datagram[:3] + bytes([randrange(16, 22)]) + datagram[4:]
            case ["cut", "in", *_]:
                return datagram[: randrange(24)]
            case ["cut", "to", *_]:
                return datagram[: self.head_size]
            case ["cut"]:
                kept = randrange(24, size - 1)
                return datagram[: kept + (kept >= self.head_size)]
            case ["nothing", "left"]:
                return b""
            case ["lengthen"]:
                return datagram + bytes(randrange(1, TOO_LONG - size))
            case ["too", "long"]:
                return datagram + bytes(TOO_LONG - size + randrange(20_000))
            case _:
                return datagram


def other_writers(session: int) -> dict[str, DataWriter]:
    """Who seals with another key, under a session of its own and under ours."""
    other, _ = both_ends(OTHER_KEY)
    return {
        "its session": DataWriter(Sealer(other.outgoing, other.session), 0, 4),
        "our session": DataWriter(Sealer(other.outgoing, session), 0, 4),
    }


def counted(world: UdpWorld, station, transport) -> Counter:
    tally = station.link.incoming[0].receiver.tally
    return Counter(
        {
            **{fate: tally[fate] for fate in Fate},
            "unknown": station.link.foreign,
            "passed on": len(station.forwarded),
            "kernel": transport.dropped_by_kernel,
        }
    )


def source(actions: list[str]):
    """What the sender itself does wrong, by the number of its packet."""

    def values(tick: int):
        number = tick // 8
        action = actions[number] if number < len(actions) else "pass"
        position = {"out of range": 2.0, "jump": 0.5}.get(action, 0.0)
        return position, tick, 0, ACTIVE_STATUS

    return values


@pytest.mark.parametrize("seed", [1, 2])
def test_every_counter_equals_what_was_injected_in_both_directions(seed: int) -> None:
    plans = plan(seed, 6), plan(seed + 10, 6)
    manglers = [Treatment(actions, seed) for actions in plans]
    with UdpWorld(*manglers) as world:
        for mangler in manglers:
            mangler.foreign = other_writers(world.a.link.session.session)
            mangler.head_size = datagram_size(len(world.b.link.incoming[0].receiver.bundle.head))
        world.a.source, world.b.source = (source(actions) for actions in plans)
        longest = max(map(len, plans))
        world.run(8 * (longest + WINDOW + 30))
        received = counted(world, world.b, world.transports[1])
        back = counted(world, world.a, world.transports[0])
    for found, actions, station in (
        (received, plans[0], world.b),
        (back, plans[1], world.a),
    ):
        wanted = expected(actions)
        # While a peer fades, for 52 ticks, nothing new is shown: six or seven packets give way.
        fades = station.link.incoming[0].weight.losses
        assert 0 <= found[Fate.SUPERSEDED] - wanted[Fate.SUPERSEDED] <= 7 * fades
        found[Fate.SUPERSEDED] = wanted[Fate.SUPERSEDED]
        wanted[Fate.ACCEPTED] += longest + WINDOW + 30 - len(actions)
        # The last packet is on its way, or not released, when the run ends.
        assert found | Counter({Fate.ACCEPTED: wanted[Fate.ACCEPTED]}) == wanted
        assert 0 <= wanted[Fate.ACCEPTED] - found[Fate.ACCEPTED] <= 1


def test_delay_loss_copies_and_flipped_bits_drawn_at_random_are_all_found() -> None:
    """The proxy's own impairments; what is drawn overlaps as it likes."""
    there = BadNetwork(delay=0.003, jitter=0.001, loss=0.05, duplicate=0.05, corrupt=0.05)
    back = BadNetwork(delay=0.005, loss=0.2, good_to_bad=0.02, bad_to_good=0.2)
    forward, backward = Impairer(there, 3), Impairer(back, 4)
    with UdpWorld(forward, backward) as world:
        world.run(8 * 1000)
        received = counted(world, world.b, world.transports[1])
        returned = counted(world, world.a, world.transports[0])
    done = forward.injected
    assert min(done.lost, done.duplicated, done.corrupted) > 20
    bad = {Fate.FORGED, Fate.FOREIGN, Fate.TRUNCATED, "unknown", "passed on"}
    # What was sent at the last sample is still in the proxy, with its copy, whole or corrupted.
    assert 0 <= done.corrupted - sum(received[name] for name in bad) <= 2
    assert 0 <= done.duplicated - received[Fate.DUPLICATE] <= 1
    intact = done.passed - (done.corrupted - (done.copies - done.duplicated))
    assert 0 <= intact - received[Fate.ACCEPTED] <= 1
    nothing = {Fate.LATE, Fate.REORDERED, Fate.REPLAYED, Fate.OUT_OF_RANGE, Fate.JUMP, Fate.FLOOD}
    assert not any(received[name] or returned[name] for name in nothing)
    assert 0 <= backward.injected.passed - returned[Fate.ACCEPTED] <= 1
