"""Delay, jitter, loss and the rest, as written and as understood."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.scenario import Channel, Direction, Scenario
from cosim.scenario.describe import average
from cosim.scenario.impairments.duplication import Duplication
from cosim.scenario.impairments.jitter import Jitter, uniform
from cosim.scenario.impairments.late import Late
from cosim.scenario.impairments.loss import Bernoulli, GilbertElliott
from cosim.scenario.impairments.reorder import Reorder
from cosim.scenario.impairments.trace import Trace

Load = Callable[..., Scenario]


def jitter_of(way: Direction) -> Jitter:
    found = way.impairments["jitter"]
    assert isinstance(found, Jitter)
    return found


@pytest.fixture
def lan(small: str, scenario_of: Load) -> Callable[[str], Channel]:
    def make(settings: str) -> Channel:
        text = small.replace("round_trip_delay: 1", settings)
        return scenario_of(text).channels["lan"]

    return make


@pytest.mark.parametrize("n", range(6))
def test_a_round_trip_is_split_with_the_larger_half_forward(
    n: int, lan: Callable[[str], Channel]
) -> None:
    channel = lan(f"round_trip_delay: {n}")
    assert channel.forward.delay.samples == -(-n // 2)
    assert channel.backward.delay.samples == n // 2
    assert channel.forward.delay.ticks == 8 * -(-n // 2)
    ticks = lan(f"round_trip_delay: {n} ticks")
    assert ticks.forward.delay.ticks == -(-n // 2)
    assert ticks.backward.delay.ticks == n // 2


def test_a_time_is_rounded_up_to_ticks_and_is_no_sample_count(
    lan: Callable[[str], Channel],
) -> None:
    channel = lan("each_way_delay: 2.44 ms")
    assert (channel.forward.delay.ticks, channel.forward.delay.samples) == (3, None)
    assert lan("each_way_delay: 0 s").forward.delay.samples == 0


def test_each_direction_may_have_its_own(lan: Callable[[str], Channel]) -> None:
    channel = lan("loss: {forward: 20 %, backward: {good_to_bad: 0.1, bad_to_good: 0.5}}")
    assert channel.forward.impairments["loss"] == Bernoulli(probability=0.2)
    assert channel.backward.impairments["loss"] == GilbertElliott(good_to_bad=0.1, bad_to_good=0.5)
    assert lan("jitter: {forward: 2}").backward.impairments == {}
    assert channel.direction("a", "b") is channel.forward
    assert channel.direction("b", "a") is channel.backward


def test_jitter_is_uniform_over_steps(lan: Callable[[str], Channel]) -> None:
    jitter = jitter_of(lan("jitter: 3").forward)
    assert (jitter.step, jitter.weights) == (8, uniform(3))
    jitter = jitter_of(lan("jitter: 2.1 ms").forward)
    assert (jitter.step, jitter.weights) == (1, uniform(3))
    jitter = jitter_of(lan("jitter: {weights: [3, 1]}".replace("3, 1", "0.75, 0.25")).forward)
    assert (jitter.step, jitter.weights) == (8, (0.75, 0.25))
    scaled = jitter_of(lan("jitter: {weights: [0.7499999, 0.2500002], step: 2 ticks}").forward)
    assert scaled.step == 2
    assert scaled.weights == pytest.approx((0.75, 0.25))


@settings(
    deadline=None,
    max_examples=30,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(rms=st.floats(0.0, 0.02))
def test_jitter_has_the_standard_deviation_asked_for(
    rms: float, lan: Callable[[str], Channel]
) -> None:
    way = lan(f"jitter: {{rms: {rms!r}}}").forward
    weights = np.array(jitter_of(way).weights if way.impairments else (1.0,))
    ticks = np.arange(len(weights))
    mean = weights @ ticks
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert (weights >= 0).all()
    assert sqrt(weights @ (ticks - mean) ** 2) == pytest.approx(rms * 1024, abs=1e-9)
    assert len(weights) <= sqrt(12) * rms * 1024 + 3


def test_late_packets_have_their_defaults(lan: Callable[[str], Channel]) -> None:
    channel = lan("reorder: 0.1, duplication: {probability: 5 %, by: 3 ticks}")
    assert channel.forward.impairments == {
        "reorder": Reorder(Late(0.1, 16)),
        "duplication": Duplication(Late(0.05, 3)),
    }
    assert lan("round_trip_delay: 1").forward.impairments == {}


@pytest.mark.parametrize(
    "nothing",
    [
        "jitter: 0",
        "jitter: {rms: 0}",
        "jitter: {weights: [1.0]}",
        "loss: 0",
        "reorder: 0 %",
        "duplication: {probability: 0, by: 3}",
    ],
)
def test_what_does_nothing_is_no_impairment(nothing: str, lan: Callable[[str], Channel]) -> None:
    assert lan(nothing).forward.impairments == {}


def test_a_trace_is_read_from_a_list_or_a_file(
    lan: Callable[[str], Channel], tmp_path: Path
) -> None:
    assert lan("trace: [0, 1, lost, 2 ticks, 1 ms]").forward.impairments == {
        "trace": Trace((0, 8, -1, 2, 2))
    }
    (tmp_path / "t.txt").write_text("# s\n0.001\n\nlost\n2 ms\n", "utf-8")
    channel = lan("trace: {forward: t.txt}")
    assert channel.forward.impairments == {"trace": Trace((2, -1, 3))}
    assert channel.backward.impairments == {}
    for text, sentence in {
        "0.001\nlate\n": "t.txt:2:1: 'late' is neither 'lost' nor a delay of 0 to 3600 s.",
        "-1\n": "t.txt:1:1: '-1' is neither 'lost' nor a delay of 0 to 3600 s.",
        "# nothing\n": "channels.lan.trace: t.txt has no packet in it.",
    }.items():
        (tmp_path / "t.txt").write_text(text, "utf-8")
        with pytest.raises(InputError) as caught:
            lan("trace: t.txt")
        assert str(caught.value).endswith(sentence)


def test_the_preset_is_what_the_thesis_measured(lan: Callable[[str], Channel]) -> None:
    """Table 1.1: round trip 2.44 ms, rms jitter 0.49 ms, 2 packets in 2.7 million lost."""
    channel = lan("include: lan_2006")
    ways = (channel.forward, channel.backward)
    ticks = sum(way.delay.ticks for way in ways)
    assert ticks == 3  # 2.44 ms are 2.5 ticks
    variance = 0.0
    for way in ways:
        weights = np.array(jitter_of(way).weights)
        steps = np.arange(len(weights))
        variance += weights @ (steps - weights @ steps) ** 2
    assert sqrt(variance) / 1024 == pytest.approx(0.49e-3, rel=0.01)
    kept = np.prod([1.0 - average(way).lost for way in ways])
    assert 1.0 - kept == pytest.approx(2 / 2.7e6, rel=0.01)
