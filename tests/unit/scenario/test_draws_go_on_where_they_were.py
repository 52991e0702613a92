"""A stream of fates that was saved goes on as if it had not been, whatever its draws remember."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.counter import happens
from cosim.master.channels.fates import Fates, FateStream
from cosim.scenario import Direction
from cosim.scenario.build.timebase import Delay
from cosim.scenario.impairments.duplication import Duplication
from cosim.scenario.impairments.effect import Draw, Effect, PacketBlock
from cosim.scenario.impairments.jitter import Jitter, uniform
from cosim.scenario.impairments.late import Late
from cosim.scenario.impairments.loss import Bernoulli, GilbertElliott
from cosim.scenario.impairments.reorder import Reorder
from cosim.scenario.impairments.trace import Trace

BURSTS = GilbertElliott(good_to_bad=0.05, bad_to_good=0.1, loss_bad=0.9, loss_good=0.01)


class Fading(Bernoulli):
    """An impairment of somebody's own, which says nothing of what it remembers."""

    remembers = Effect.remembers

    def draw(self, key: int) -> Draw:
        level = 0

        def fade(packets: PacketBlock) -> None:
            nonlocal level
            for i, moves in enumerate(happens(key, 9, 0.5, packets.first, packets.count)):
                level = (level + int(moves)) % 7
                packets.delays[i] += level

        return fade


EFFECTS: dict[str, Mapping[str, Effect]] = {
    "trace": {"trace": Trace(fates=(3, 1, -1, 2, 5))},
    "all": {
        "jitter": Jitter(step=1, weights=uniform(3)),
        "loss": BURSTS,
        "reorder": Reorder(Late(0.1, 16)),
        "duplication": Duplication(Late(0.1, 8)),
    },
    "foreign": {"fading": Fading(probability=0.5), "loss": BURSTS},
}


def stream(name: str) -> FateStream:
    direction = Direction(delay=Delay(ticks=8, samples=1), impairments=EFFECTS[name])
    return Fates(direction=direction, key=7).begin()


@pytest.mark.parametrize("name", EFFECTS)
@settings(deadline=None, max_examples=20)
@given(before=st.lists(st.integers(1, 300), max_size=5), after=st.integers(1, 500))
def test_a_stream(name: str, before: list[int], after: int) -> None:
    whole, first, second = stream(name), stream(name), stream(name)
    for count in before:
        first.take(count)
    second.load(json.loads(json.dumps(first.save())))
    expected = whole.take(sum(before) + after)
    for drawn, wanted in zip(second.take(after), expected, strict=True):
        np.testing.assert_array_equal(drawn, wanted[sum(before) :])


def test_a_used_stream_begins_again() -> None:
    used, fresh = stream("all"), stream("all")
    start = used.save()
    used.take(100)
    used.load(start)
    np.testing.assert_array_equal(used.take(50)[0], fresh.take(50)[0])


@pytest.mark.parametrize("state", [1, None, "bad"])
def test_a_state_that_is_none(state: Any) -> None:
    with pytest.raises(TypeError, match="true or false"):
        stream("all").load({"next": 5, "draws": {"loss": state}})
