"""Channels do what they say: against a model of a channel that is a few lines of plain Python."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fmus.probe
from cosim.base.counter import draws, stream_key
from cosim.master.channels.fates import LOST, NO_COPY, Fates
from cosim.scenario import Delay, Direction
from cosim.scenario.impairments.duplication import Duplication
from cosim.scenario.impairments.jitter import Jitter
from cosim.scenario.impairments.late import Late
from cosim.scenario.impairments.loss import Bernoulli, GilbertElliott
from cosim.scenario.impairments.reorder import Reorder
from tests.support.master.master_support import run, scenario_of

SEND = 8
"""Ticks between packets."""

directions = st.builds(
    lambda delay, **effects: Direction(
        delay=delay, impairments={name: e for name, e in effects.items() if e is not None}
    ),
    delay=st.builds(Delay, ticks=st.integers(0, 30), samples=st.none()),
    jitter=st.sampled_from(
        [None, Jitter(step=1, weights=(0.5, 0.3, 0.2)), Jitter(step=8, weights=(0.2,) * 5)]
    ),
    loss=st.sampled_from(
        [
            None,
            Bernoulli(probability=0.3),
            GilbertElliott(good_to_bad=0.2, bad_to_good=0.4, loss_bad=0.9),
        ]
    ),
    reorder=st.sampled_from([None, Reorder(Late(0.3, 20))]),
    duplication=st.sampled_from([None, Duplication(Late(0.4, 3))]),
)


def told(direction: Direction) -> dict[str, Any]:
    """The channel's settings in a scenario, the same both ways."""
    effects = {name: effect.write(SEND) for name, effect in direction.impairments.items()}
    return {"each_way_delay": f"{direction.delay.ticks} ticks", **effects}


@settings(
    deadline=None,
    max_examples=15,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(directions, st.integers(0, 1000))
def test_what_is_held_is_the_newest_that_has_arrived(
    tmp_path: Path, direction: Direction, seed: int
) -> None:
    ticks = 400
    probe = {"fmu": str(fmus.probe.find("probe_tick")), "rate": 1024, "feedthrough": True}
    scenario = scenario_of(
        tmp_path,
        {
            "duration": ticks / 1024,
            "seed": seed,
            "rates": {"network": 1024 / SEND},
            "components": {"a": {**probe, "station": "a"}, "b": {**probe, "station": "b"}},
            "channels": {"lan": {"between": ["a", "b"], "rate": "network", **told(direction)}},
            "connections": ["a.tick -> b.heard via lan"],
        },
    )
    sink, simulation = run(scenario)
    fates = Fates(
        scenario.channels["lan"].forward, stream_key(seed, "lan", "forward", "128")
    ).begin()
    count = -(-ticks // SEND)
    delays, copies = fates.take(count)

    seen = np.zeros(ticks, dtype=np.int64)
    newest, delivered, late = -1, 0, 0
    arrivals: dict[int, list[int]] = {}
    for number, delay in enumerate(delays.tolist()):
        if delay != LOST:
            arrivals.setdefault(number * SEND + delay, []).append(number)
    for tick in range(ticks):
        due = arrivals.get(tick, [])
        if due and max(due) > newest:
            newest = max(due)
            delivered, late = delivered + 1, late + len(due) - 1
        else:
            late += len(due)
        seen[tick] = newest * SEND if newest >= 0 else 0
    np.testing.assert_array_equal(sink.signal("b.seen"), seen)

    counted = simulation.outcome.channels["lan.forward"]
    second = [
        number * SEND + copy < ticks
        for number, copy in enumerate(copies.tolist())
        if copy != NO_COPY
    ]
    assert counted.sent == count
    assert counted.lost == int(np.count_nonzero(delays == LOST))
    assert (counted.delivered, counted.late) == (delivered, late)
    assert counted.duplicate == sum(second)
    assert counted.sent == counted.delivered + counted.late + counted.lost + counted.in_flight


@settings(deadline=None, max_examples=50)
@given(directions, st.lists(st.integers(1, 50), min_size=1, max_size=6))
def test_fates_do_not_depend_on_how_many_are_drawn_at_a_time(
    direction: Direction, blocks: list[int]
) -> None:
    whole = Fates(direction, 5).begin().take(sum(blocks))
    pieces = Fates(direction, 5).begin()
    drawn = [pieces.take(block) for block in blocks]
    for side in (0, 1):
        np.testing.assert_array_equal(whole[side], np.concatenate([pair[side] for pair in drawn]))


def test_probabilities_and_jitter_are_met() -> None:
    count = 200_000
    direction = Direction(
        delay=Delay(ticks=4),
        impairments={
            "jitter": Jitter(weights=(0.5, 0.3, 0.2)),
            "loss": Bernoulli(probability=0.1),
        },
    )
    delays, _ = Fates(direction, stream_key(1, "x")).begin().take(count)
    assert abs(np.mean(delays == LOST) - 0.1) < 0.003
    arrived = delays[delays != LOST] - 4
    for extra, weight in enumerate((0.5, 0.3, 0.2)):
        assert abs(np.mean(arrived == extra) - weight) < 0.005


def test_gilbert_elliott_loses_in_bursts() -> None:
    loss = GilbertElliott(good_to_bad=0.05, bad_to_good=0.25)
    delays, _ = (
        Fates(Direction(impairments={"loss": loss}), stream_key(1, "x")).begin().take(200_000)
    )
    lost = delays == LOST
    assert abs(lost.mean() - 0.05 / 0.30) < 0.005
    starts = np.count_nonzero(lost[1:] & ~lost[:-1])
    assert abs(lost.sum() / starts - 1 / 0.25) < 0.1  # mean burst length


def test_the_generator_gives_the_same_integers_everywhere() -> None:
    """Written out once: a change of these numbers changes every recorded run."""
    assert [
        hex(value) for value in draws(stream_key(7, "lan", "forward", "128"), 1, 0, 3)
    ] == GOLDEN
    assert draws(3, 0, 5, 1)[0] == draws(3, 0, 0, 6)[5]


GOLDEN = ["0x8d6f15cb03294ce1", "0x8a112c6e30222940", "0xb74e6c625aa5d624"]
