"""A turned channel is, packet by packet, a channel that was so from that packet on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import fmus.probe
from cosim.base.counter import stream_key
from cosim.base.recording import MemorySink
from cosim.master.channels.fates import LOST, Fates
from cosim.master.run.simulation import Simulation, assemble
from cosim.scenario import Direction, Scenario
from cosim.scenario.build.dials import turned
from tests.support.master.master_support import run, scenario_of

SEND, TICKS = 8, 400
"""Ticks between packets, and in a run."""
RATE = 1024

turns = st.lists(
    st.tuples(
        st.integers(0, TICKS // SEND - 1).map(lambda packet: packet * SEND),
        st.sampled_from(["delay", "jitter", "loss"]),
        st.integers(0, 24),
    ),
    min_size=1,
    max_size=6,
    unique_by=lambda turn: turn[:2],
)


def written(name: str, amount: int) -> Any:
    return amount / 24 if name == "loss" else f"{amount} ticks"


def probes(channel: dict[str, Any], **more: Any) -> dict[str, Any]:
    probe = {"fmu": str(fmus.probe.find("probe_tick")), "rate": RATE, "feedthrough": True}
    return {
        "duration": TICKS / RATE,
        "rates": {"network": RATE / SEND},
        "components": {"a": {**probe, "station": "a"}, "b": {**probe, "station": "b"}},
        "channels": {"lan": {"between": ["a", "b"], "rate": "network", **channel}},
        "connections": ["a.tick -> b.heard via lan"],
        **more,
    }


def delays_of(scenario: Scenario, turns: list[tuple[int, str, int]]) -> list[int]:
    """The fate of each packet, by drawing all packets anew for each direction that there was."""
    channel = scenario.channels["lan"].forward
    standing: dict[str, float] = {}
    found: list[int] = []
    for packet in range(TICKS // SEND):
        for tick, name, amount in turns:
            if tick == packet * SEND:
                standing[name] = amount / 24 if name == "loss" else amount / RATE
        direction: Direction = turned(channel, standing, scenario.base_rate)
        fates = Fates(direction, stream_key(scenario.seed, "lan", "forward", "128")).begin()
        found.append(int(fates.take(packet + 1)[0][packet]))
    return found


def held(delays: list[int]) -> np.ndarray[Any, Any]:
    """Which packet is held at each tick: the newest of those that have arrived."""
    arrival = [
        number * SEND + delay if delay != LOST else TICKS for number, delay in enumerate(delays)
    ]
    newest = [
        max((n for n, at in enumerate(arrival) if at <= tick), default=-1) for tick in range(TICKS)
    ]
    return np.array(newest)


def in_chunks(scenario: Scenario, chunk: int) -> tuple[MemorySink, Simulation]:
    sink = MemorySink()
    pauses = {tick: lambda: None for tick in range(chunk, TICKS, chunk)}
    with assemble(scenario) as simulation:
        simulation.run(sink, pauses=pauses)
    return sink, simulation


@settings(
    deadline=None,
    max_examples=25,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
)
@given(
    turns,
    st.sampled_from(
        [
            {"delay": {"forward": "9 ticks", "backward": 0}},
            {"jitter": "4 ticks"},
            {"loss": 0.2, "each_way_delay": 1},
            {"reorder": 0.2, "duplication": 0.3},
        ]
    ),
    st.sampled_from([1, 37, 1024]),
)
def test_each_packet_goes_by_what_was_in_force_when_it_was_sent(
    tmp_path: Path, turns: list[tuple[int, str, int]], channel: dict[str, Any], chunk: int
) -> None:
    events = [
        {"at": f"{tick} ticks", "set": {f"lan.forward.{name}": written(name, amount)}}
        for tick, name, amount in turns
    ]
    scenario = scenario_of(tmp_path, probes(channel, events=events))
    sink, simulation = in_chunks(scenario, chunk)
    delays = delays_of(scenario, turns)
    np.testing.assert_array_equal(sink.signal("lan.forward.sequence"), held(delays))
    counted = simulation.outcome.channels["lan.forward"]
    assert counted.lost == delays.count(LOST)
    assert counted.sent == counted.delivered + counted.late + counted.lost + counted.in_flight


def test_a_draw_that_remembers_goes_on_where_it_was(tmp_path: Path) -> None:
    """Bursts of loss are the same packets', whatever the delay is turned to."""
    bursts = {"loss": {"good_to_bad": 0.2, "bad_to_good": 0.3}}
    events = [{"at": f"{tick} ticks", "set": {"lan.delay": 1}} for tick in (80, 160)]
    events[1]["set"] = {"lan.delay": 0}
    plain, _ = run(scenario_of(tmp_path, probes(bursts)))
    scenario = scenario_of(tmp_path, probes(bursts, events=events))
    found, simulation = run(scenario)
    key = stream_key(scenario.seed, "lan", "forward", "128")
    lost = Fates(scenario.channels["lan"].forward, key).begin().take(TICKS // SEND)[0] == LOST
    assert simulation.outcome.channels["lan.forward"].lost == np.count_nonzero(lost) > 5
    late = slice(176, None)
    np.testing.assert_array_equal(
        plain.signal("lan.forward.sequence")[late], found.signal("lan.forward.sequence")[late]
    )


def test_packets_in_flight_keep_their_fates_and_are_overtaken(tmp_path: Path) -> None:
    """From 3 samples of delay to none: what is under way then is late, and dropped."""
    events = [{"at": f"{10 * SEND} ticks", "set": {"lan.forward.delay": 0}}]
    channel = {"delay": {"forward": 3, "backward": 0}}
    sink, simulation = run(scenario_of(tmp_path, probes(channel, events=events)))
    sequence = sink.signal("lan.forward.sequence")
    assert sequence[10 * SEND - 1] == 6
    assert sequence[10 * SEND] == 10
    counted = simulation.outcome.channels["lan.forward"]
    assert counted.late == 3
    assert counted.in_flight == 0


def test_what_is_in_force_is_recorded(tmp_path: Path) -> None:
    events = [
        {"at": "80 ticks", "set": {"lan.round_trip_delay": 3}},
        {"at": "83 ticks", "set": {"lan.loss": "25 %"}},  # for the packet of tick 88
    ]
    sink, _ = run(scenario_of(tmp_path, probes({}, events=events)))
    sent = SEND / RATE
    forward, backward = (sink.signal(f"lan.{way}.delay") for way in ("forward", "backward"))
    np.testing.assert_array_equal(forward, np.where(np.arange(50) < 10, 0.0, 2 * sent))
    np.testing.assert_array_equal(backward, np.where(np.arange(50) < 10, 0.0, sent))
    loss = sink.signal("lan.forward.loss")
    np.testing.assert_array_equal(loss, np.where(np.arange(50) < 11, 0.0, 0.25))


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_a_component_turns_a_channel_from_the_next_tick_on(tmp_path: Path, flavour: str) -> None:
    """What it puts out at tick k is what events have turned to before tick k + 1."""
    connected = probes(
        {"delay": {"forward": 1, "backward": 0}}, knobs={"lan.forward.delay": {"maximum": 4}}
    )
    knob = {"mode": "step", "start_time": 159 / RATE, "offset": SEND / RATE, "amplitude": 0.0}
    knob["amplitude"] = 2 * SEND / RATE
    connected["components"]["knob"] = {
        "fmu": "signal", "flavour": flavour, "rate": RATE, "station": "a", "parameters": knob,
    }  # fmt: skip
    connected["connections"].append("knob.value -> lan.forward.delay")
    events = [{"at": "160 ticks", "set": {"lan.forward.delay": 3}}]
    by_event = probes({"delay": {"forward": 1, "backward": 0}}, events=events)
    sinks = [run(scenario_of(tmp_path, written))[0] for written in (connected, by_event)]
    for name in ("b.seen", "lan.forward.sequence", "lan.forward.delay"):
        np.testing.assert_array_equal(sinks[0].signal(name), sinks[1].signal(name))
    assert set(np.unique(sinks[0].signal("lan.forward.delay"))) == {SEND / RATE, 3 * SEND / RATE}
