"""Whatever somebody without the key does to datagrams: no loop ends, forces stay in their bounds,
and once he lets go everybody is back in the time that is stated."""

from __future__ import annotations

import pytest

from tests.support.link.attacker import CALM, Attacker
from tests.support.link.bounds import check_records
from tests.support.link.whole import MILLISECOND, SECOND, Wire, World

BACK = 1200 * MILLISECOND
"""Within which two that run have a session again."""
START = 2500 * MILLISECOND
"""The same for a station that has to join: clocks, a second of lead, others that it waits for."""
RAMP = 1400 * MILLISECOND
"""Sixteen good samples and a ramp of a second; the way has to be believed again before."""


def survive(seed: int, names: list[str]) -> World:
    attacker = Attacker(seed, names)
    world = World(Wire(attacker.treat), names)
    for name in names:
        world.start(name)
    world.run(CALM, attacker.events(world))
    ran = [station.running for station in world.stations.values()]
    world.run(CALM + BACK)
    if all(ran):
        assert world.agreed()
    world.run(CALM + BACK + START + RAMP + SECOND)
    assert world.agreed()
    assert world.weights() == [1.0] * (len(names) * (len(names) - 1))
    check_records(world)
    return world


SEEDS = [*range(12), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(12, 700))]
TRIPLES = [*range(2), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(2, 300))]


@pytest.mark.parametrize("seed", SEEDS)
def test_two_stations_survive_a_drawn_schedule(seed: int) -> None:
    survive(seed, ["a", "b"])


@pytest.mark.parametrize("seed", TRIPLES)
def test_three_stations_survive_a_drawn_schedule(seed: int) -> None:
    survive(1000 + seed, ["a", "b", "c"])
