"""No component reads its future, and what crosses a channel is as old as rate and delay say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fmus.probe
from tests.support.master.master_support import run, scenario_of

TICKS = 64


def two_probes(
    channel: dict[str, Any], *, fast: int = 1, slow: int = 8, flavour: str = "fmi3"
) -> dict[str, Any]:
    """A probe at 1024/``fast`` Hz and one at 1024/``slow`` Hz that hear each other."""
    probe = str(fmus.probe.find("probe_tick", flavour))

    def component(station: str, period: int) -> dict[str, Any]:
        return {
            "fmu": probe,
            "station": station,
            "rate": 1024 / period,
            "feedthrough": True,
            "parameters": {"period": period},
        }

    return {
        "duration": TICKS / 1024,
        "base_rate": 1024,
        "rates": {"network": 128},
        "components": {"fast": component("a", fast), "slow": component("b", slow)},
        "channels": {"lan": {"between": ["a", "b"], "rate": "network", **channel}},
        "connections": ["fast.tick -> slow.heard via lan", "slow.tick -> fast.heard via lan"],
        "record": ["fast.*", "slow.*", {"signals": "lan.*", "rate": 1024}],
    }


def held(signal: Any, period: int) -> Any:
    """A signal of every ``period`` ticks, shown at every tick."""
    return np.repeat(signal, period)[:TICKS]


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3"])
@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_ages_are_exactly_what_rate_and_delay_say(tmp_path: Path, n: int, flavour: str) -> None:
    there, back = (n + 1) // 2, n // 2
    sink, _ = run(scenario_of(tmp_path, two_probes({"round_trip_delay": n}, flavour=flavour)))
    tick = np.arange(TICKS)
    for way, samples in (("forward", there), ("backward", back)):
        expected = np.where(tick < 8 * samples, tick, tick % 8 + 8 * samples)
        np.testing.assert_array_equal(sink.signal(f"lan.{way}.age"), expected)
        sequence = np.where(tick < 8 * samples, -1, tick // 8 - samples)
        np.testing.assert_array_equal(sink.signal(f"lan.{way}.sequence"), sequence)
    # What is seen is what was sampled then; before the first arrival, the source's first value.
    fast = sink.signal("fast.seen")
    np.testing.assert_array_equal(fast, tick - sink.signal("lan.backward.age"))
    slow = held(sink.signal("slow.seen"), 8)
    sampled = held((tick - sink.signal("lan.forward.age"))[::8], 8)
    np.testing.assert_array_equal(slow, sampled)


@settings(
    deadline=None,
    max_examples=10,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(
    st.sampled_from([1, 2, 4]),
    st.sampled_from([8, 16, 32]),
    st.integers(0, 40),
    st.none() | st.lists(st.just("lost") | st.integers(0, 4), min_size=1, max_size=20),
)
def test_nobody_sees_the_future(
    tmp_path: Path, fast: int, slow: int, delay: int, trace: list[Any] | None
) -> None:
    channel = {"each_way_delay": f"{delay} ticks"} if trace is None else {"trace": trace}
    written = two_probes(channel, fast=fast, slow=slow)
    sink, _ = run(scenario_of(tmp_path, written))
    for name, period in (("fast", fast), ("slow", slow)):
        tick = np.arange(0, TICKS, period)
        np.testing.assert_array_equal(sink.signal(f"{name}.tick"), tick)
        assert (sink.signal(f"{name}.seen") <= tick).all()
        assert (np.diff(sink.signal(f"{name}.seen")) >= 0).all()


def test_inside_a_station_a_slow_result_is_not_shown_before_its_step_is_over(
    tmp_path: Path,
) -> None:
    written = two_probes({})
    written["components"]["slow"]["station"] = "a"
    del written["channels"], written["record"]
    written["connections"] = ["fast.tick -> slow.heard", "slow.last_heard -> fast.heard"]
    sink, _ = run(scenario_of(tmp_path, written))
    tick = np.arange(TICKS)
    # The step over [k, k + 8) reads the input at k; its result is shown from k + 8 on.
    expected = np.where(tick < 8, -1, tick // 8 * 8 - 8)
    np.testing.assert_array_equal(sink.signal("fast.seen"), expected)


def test_without_feedthrough_an_answer_lags_one_step(tmp_path: Path) -> None:
    written = two_probes({}, slow=1)
    written["components"]["slow"] |= {"station": "a", "feedthrough": False}
    del written["channels"], written["record"]
    written["connections"] = ["fast.tick -> slow.heard", "slow.seen -> fast.heard"]
    sink, simulation = run(scenario_of(tmp_path, written))
    tick = np.arange(TICKS)
    np.testing.assert_array_equal(sink.signal("slow.seen")[1:], tick[1:] - 1)
    np.testing.assert_array_equal(sink.signal("fast.seen"), sink.signal("slow.seen"))
    assert simulation.assembly.lagging == ("fast.tick -> slow.heard",)


def test_a_connection_with_its_own_rate_and_delay_samples_and_holds(tmp_path: Path) -> None:
    written = two_probes({}, slow=1)
    written["components"]["slow"] |= {"station": "a"}
    del written["channels"], written["record"]
    written["connections"] = ["fast.tick -> slow.heard at 256 Hz delay 3 ticks"]
    sink, _ = run(scenario_of(tmp_path, written))
    tick = np.arange(TICKS)
    expected = np.where(tick < 3, 0, (tick - 3) // 4 * 4)
    np.testing.assert_array_equal(sink.signal("slow.seen"), expected)


def test_the_age_of_a_packet_can_be_connected(tmp_path: Path) -> None:
    written = two_probes({"each_way_delay": 1})
    written["connections"] = [
        "slow.tick -> fast.heard_real via lan",
        "lan.backward.age -> fast.heard",
    ]
    sink, _ = run(scenario_of(tmp_path, written))
    np.testing.assert_array_equal(sink.signal("fast.seen"), sink.signal("lan.backward.age"))


def test_initial_start_keeps_the_inputs_own_value(tmp_path: Path) -> None:
    written = two_probes({"each_way_delay": 1})
    written["components"]["fast"]["start"] = {"heard": -7}
    written["connections"] = [
        {"from": "slow.tick", "to": "fast.heard", "via": "lan", "initial": "start"}
    ]
    sink, _ = run(scenario_of(tmp_path, written))
    np.testing.assert_array_equal(sink.signal("fast.seen")[:9], [-7] * 8 + [0])
