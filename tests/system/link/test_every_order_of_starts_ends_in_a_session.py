"""Stations are started, killed and started again in every order, before and during the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from tests.support.link.bounds import check_records
from tests.support.link.whole import MILLISECOND, SECOND, Wire, World

WAY = 2 * MILLISECOND
MOMENTS = {
    "while they greet": 3 * MILLISECOND,
    "with a session and no start": 200 * MILLISECOND,
    "when the start is agreed on": 500 * MILLISECOND,
    "just before the first tick": 1400 * MILLISECOND,
    "in the run": 2600 * MILLISECOND,
}
"""Since both were started, on this wire."""
AWAY = {"at once": 0, "before it is missed": 300 * MILLISECOND, "later": 1500 * MILLISECOND}
BACK = 6 * SECOND
"""After the last start: a second until it is noticed, the start's lead, the ramp."""


def run(names: str, events: list[tuple[int, str, str]]) -> World:
    """Carry out (true time, "start" or "kill", name) and look at the end of it."""
    world = World(
        Wire(lambda _source, _target, datagram, now: [(now + WAY, datagram)]), list(names)
    )
    actions: dict[str, Callable] = {"start": world.start, "kill": world.kill}
    planned = [(at, lambda what=what, name=name: actions[what](name)) for at, what, name in events]
    last = max(at for at, _, _ in events)
    world.run(last + BACK, planned)
    assert all(station.running for station in world.stations.values())
    assert world.agreed()
    assert set(world.weights()) == {1.0}
    check_records(world)
    # One grid: session tick 0 lies at one true time for all of them.
    epochs = [s.clock.true(s.grid.epoch) for s in world.stations.values()]
    assert max(epochs) - min(epochs) < 2 * MILLISECOND
    return world


def orders(restarts: dict[str, int]) -> Iterator[list[tuple[str, str]]]:
    """Every order of the events of stations that are restarted so many times each."""
    lives = {name: 1 + 2 * times for name, times in restarts.items()}

    def rest(left: dict[str, int]) -> Iterator[list[tuple[str, str]]]:
        if not any(left.values()):
            yield []
        for name, events in left.items():
            if events:
                what = "start" if events % 2 else "kill"
                for after in rest({**left, name: events - 1}):
                    yield [(what, name), *after]

    return rest(lives)


def every(*restarts: str, gaps: list[int]) -> list:
    """Parameters of the orders of ``restarts`` like ``a0 b2``, with the same pause in between."""
    found = []
    for counts in restarts:
        for order in orders({word[0]: int(word[1:]) for word in counts.split()}):
            written = " ".join(name + {"start": "+", "kill": "-"}[what] for what, name in order)
            found += [pytest.param(order, gap, id=f"{written}, {gap // 1000} us") for gap in gaps]
    return found


def in_order(order: list[tuple[str, str]], gap: int) -> None:
    names = "".join(sorted({name for _, name in order}))
    run(names, [(number * gap, *event) for number, event in enumerate(order)])


@pytest.mark.parametrize(("order", "gap"), every("a0 b0", gaps=[0, 3 * MILLISECOND, 5 * SECOND]))
def test_two_are_started_in_any_order(order: list[tuple[str, str]], gap: int) -> None:
    in_order(order, gap)


@pytest.mark.parametrize(("order", "gap"), every("a0 b0 c0", gaps=[3 * MILLISECOND]))
def test_three_are_started_in_any_order(order: list[tuple[str, str]], gap: int) -> None:
    in_order(order, gap)


@pytest.mark.one_in(12)
@pytest.mark.parametrize(
    ("order", "gap"),
    every(
        "a1 b0",
        "a0 b1",
        "a1 b1",
        "a2 b0",
        "a0 b2",
        gaps=[0, *(each * MILLISECOND for each in (3, 60, 400, 900, 1000, 2000))],
    ),
)
def test_two_are_started_killed_and_restarted_in_every_order(
    order: list[tuple[str, str]], gap: int
) -> None:
    in_order(order, gap)


@pytest.mark.one_in(12)
@pytest.mark.parametrize(
    ("order", "gap"),
    [
        *every("a0 b0 c0", gaps=[0, 2 * SECOND]),
        *every(
            "a1 b0 c0",
            "a0 b1 c0",
            "a0 b0 c1",
            gaps=[3 * MILLISECOND, 60 * MILLISECOND, 400 * MILLISECOND, 1600 * MILLISECOND],
        ),
        *every("a1 b1 c0", "a1 b0 c1", "a0 b1 c1", gaps=[30 * MILLISECOND, 900 * MILLISECOND]),
    ],
)
def test_three_are_started_killed_and_restarted_in_every_order(
    order: list[tuple[str, str]], gap: int
) -> None:
    in_order(order, gap)


@pytest.mark.parametrize("away", AWAY)
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("victim", ["a", "b"])
def test_one_of_two_is_restarted_at_any_moment(victim: str, moment: str, away: str) -> None:
    at = MOMENTS[moment]
    again = at + AWAY[away]
    run(
        "ab",
        [(0, "start", "a"), (0, "start", "b"), (at, "kill", victim), (again, "start", victim)],
    )


@pytest.mark.one_in(12)
@pytest.mark.parametrize("away", AWAY)
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("victims", ["aa", "ab", "ba", "bb"])
@pytest.mark.parametrize("second", list(MOMENTS))
def test_two_restarts_of_two_stations(victims: str, moment: str, second: str, away: str) -> None:
    first, then = MOMENTS[moment], MOMENTS[moment] + MOMENTS[second] + MILLISECOND
    pause = AWAY[away]
    events = [(0, "start", "a"), (0, "start", "b")]
    for at, victim in zip((first, then + pause), victims, strict=True):
        events += [(at, "kill", victim), (at + pause, "start", victim)]
    run("ab", events)


@pytest.mark.one_in(12)
@pytest.mark.parametrize("away", AWAY)
@pytest.mark.parametrize("moment", MOMENTS)
@pytest.mark.parametrize("victims", ["a", "b", "c", "ab", "bc", "ca", "abc"])
def test_any_of_three_are_restarted_at_any_moment(victims: str, moment: str, away: str) -> None:
    at, events = MOMENTS[moment], [(0, "start", name) for name in "abc"]
    for victim in victims:
        events += [(at, "kill", victim), (at + AWAY[away], "start", victim)]
    run("abc", events)
