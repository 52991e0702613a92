"""Whatever somebody without the key does to datagrams: no loop ends, forces stay in their bounds,
and once he lets go everybody is back in the time that is stated."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from tests.support.link.attacker import Attacker, Hardest
from tests.support.link.bounds import check_records
from tests.support.link.silences import BACK, check_silences
from tests.support.link.whole import MILLISECOND, SECOND, Wire, World

START = 2500 * MILLISECOND
"""The same for a station that has to join: clocks, a second of lead, others that it waits for."""
RAMP = 1400 * MILLISECOND
"""Sixteen good samples and a ramp of a second; the way has to be believed again before."""


def survive(attacker: Attacker) -> World:
    names, calm = attacker.names, attacker.calm
    world = World(Wire(attacker.treat), names)
    for name in names:
        world.start(name)
    world.run(calm, attacker.events(world))
    ran = [station.running for station in world.stations.values()]
    world.run(calm + BACK)
    if all(ran):
        assert world.agreed()
    world.run(calm + BACK + START + RAMP + SECOND)
    assert world.agreed()
    assert world.weights() == [1.0] * (len(names) * (len(names) - 1))
    check_records(world)
    check_silences(world, attacker)
    return world


class Asked:
    """In place of a world: notes when an attacker kills whom."""

    def __init__(self) -> None:
        self.stations: dict[str, object] = {}
        self.wire = SimpleNamespace(now=0, put=lambda *_: None)
        self.kills: list[tuple[int, str]] = []

    def start(self, name: str) -> None:
        """Nobody is there."""

    def kill(self, name: str) -> None:
        self.kills.append((self.wire.now, name))


def test_the_twenty_of_the_real_sockets_hold_what_is_hardest() -> None:
    found: set[str] = set()
    for seed in range(20):
        attacker, world = Attacker(seed, ["station_a", "station_b"]), Asked()
        for at, act in sorted(attacker.events(world), key=lambda event: event[0]):
            world.wire.now = at
            act()
        found |= {"a confirmation is withheld"} if attacker.withholds else set()
        if any(span.end - span.begin > 280 * MILLISECOND for span in attacker.bursts):
            found.add("300 ms are released at once")
        # The station whose name sorts first answers.
        if any(
            span.begin <= at < span.end and name == "station_a"
            for span in attacker.replays
            for at, name in world.kills
        ):
            found.add("greetings are replayed against a restarted answerer")
        if any(span.source is None for span in attacker.blackholes):
            found.add("both ways are silent")
        if any(span.source is not None for span in attacker.blackholes):
            found.add("one way is silent")
    assert len(found) == 5, found


LONG = (pytest.mark.slow, *7 * (pytest.mark.exhaustive,))
SEEDS = [*range(12), *(pytest.param(seed, marks=LONG[seed % 8]) for seed in range(12, 700))]
TRIPLES = [*range(2), *(pytest.param(seed, marks=LONG[seed % 8]) for seed in range(2, 300))]


@pytest.mark.parametrize("seed", SEEDS)
def test_two_stations_survive_a_drawn_schedule(seed: int) -> None:
    survive(Attacker(seed, ["a", "b"]))


@pytest.mark.parametrize("seed", TRIPLES)
def test_three_stations_survive_a_drawn_schedule(seed: int) -> None:
    survive(Attacker(1000 + seed, ["a", "b", "c"]))


@pytest.mark.parametrize("seed", range(4))
def test_two_stations_survive_what_is_hardest(seed: int) -> None:
    survive(Hardest(seed, ["a", "b"]))
