"""Knobs and events are judged before the first tick: sentence, place, and what to write instead."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from tests.support.master.master_support import scenario_of

HEAD = """\
duration: 100 ms
rates: {control: 1024 Hz, network: 128 Hz}
components:
  knob:    {fmu: signal, rate: control, station: here}
  coupler: {fmu: virtual_coupler, rate: control, station: there}
  user:    {fmu: operator, rate: control, station: here}
channels:
  lan: {between: [here, there], rate: network, round_trip_delay: 1}
connections:
  - knob.value -> coupler.position_a via lan
"""

EVENTS = [
    ("{at: 0, set: {coupler.stifness: 1}}", "no parameter coupler.stifness. Did you mean stiff"),
    ("{at: 0, set: {copler.stiffness: 1}}", "no component or channel 'copler'. Did you mean coup"),
    ("{at: 0, set: {coupler.position_b: 1}}", "position_b is an input, which a connection drives"),
    ("{at: 0, set: {coupler.force: 1}}", "is of causality 'output'; only a tunable parameter"),
    (
        "{at: 0, set: {coupler.computation_delay_ticks: 1}}",
        "a fixed parameter, set before the start and never again. Of coupler can be turned: damp",
    ),
    ("{at: 0, set: {coupler.stiffness: -1}}", "the least that it can be is 0 N/m"),
    ("{at: 0, set: {coupler.stiffness: 1 m}}", "which does not convert to N/m"),
    ("{at: 0, set: {coupler.stiffness: [1, 2]}}", "coupler.stiffness"),
    ("{at: 0, set: {user.stiffness: [1, 2, 3]}}", "user.stiffness has 2 elements"),
    ("{at: 0, set: {lan.dealy: 1}}", "nothing called 'dealy' that could be turned. Did you mean "),
    ("{at: 0, set: {lan.reorder: 1}}", "lan.reorder stays as it is while the scenario runs"),
    ("{at: 0, set: {lan.loss: 1.5}}", "lan.loss: 1.5 is not a probability"),
    ("{at: 0, set: {lan.delay: -1}}", "lan.delay: -1 is out of range"),
    ("{at: 0, set: {lan.loss: {good_to_bad: 1}}}", "set.lan.loss"),
    ("{at: 100 ms, set: {lan.loss: 1}}", "at tick 103, and the run ends before that"),
    ("{at: -1 s, set: {lan.loss: 1}}", "-1 s is out of range"),
    ("{at: 3 m, set: {lan.loss: 1}}", "3 m"),
    ("{at: 0, set: {}}", "set"),
    ("{at: 0}", "needs 'set'"),
    ("{at: 0, sets: {lan.loss: 1}}", "unknown key 'sets'"),
    ("{at: 0, set: {lan: 1}}", "'lan' is no signal; write component.variable"),
]


def refusal(folder: Path, text: str, sets: tuple[str, ...] = ()) -> InputError:
    with pytest.raises(InputError) as refused:
        assemble(scenario_of(folder, text, sets))
    return refused.value


@pytest.mark.parametrize(("event", "sentence"), EVENTS)
def test_an_event(event: str, sentence: str, tmp_path: Path) -> None:
    text = HEAD.replace("100 ms", "100 ms") + f"events:\n  - {event}\n"
    error = refusal(tmp_path, text)
    assert sentence in str(error)
    assert ":13:" in str(error)


def test_two_events_on_one_target_at_one_tick(tmp_path: Path) -> None:
    text = HEAD + (
        "events:\n  - {at: 0.01, set: {coupler.stiffness: 1}}\n"
        "  - {at: 11 ticks, set: {coupler.stiffness: 2}}\n"
    )
    error = str(refusal(tmp_path, text))
    assert "coupler.stiffness is turned twice at tick 11; the other is at " in error
    assert "test.yaml:14:" in error
    assert "test.yaml:13:" in error


def test_two_events_of_which_the_first_would_never_be_in_force(tmp_path: Path) -> None:
    text = HEAD + (
        "events:\n  - {at: 1 tick, set: {lan.loss: 1}}\n"
        "  - {at: 2 ticks, set: {lan.forward.loss: 0.5}}\n"
    )
    error = str(refusal(tmp_path, text))
    assert "turned twice at ticks 1 and 2, both in force from tick 8 on" in error


def test_an_event_that_comes_into_force_after_the_end(tmp_path: Path) -> None:
    text = HEAD + "events:\n  - {at: 98 ticks, set: {lan.loss: 1}}\n"
    error = str(refusal(tmp_path, text))
    assert "lan.forward.loss is turned at tick 98 and would come into force at tick 104" in error


def test_what_a_connection_drives(tmp_path: Path) -> None:
    text = HEAD.replace("via lan", "via lan\n  - user.force[1] -> knob.offset") + (
        "events:\n  - {at: 0, set: {knob.offset: 1}}\n"
    )
    assert "knob.offset is driven by user.force[1] -> knob.offset" in str(refusal(tmp_path, text))


@pytest.mark.parametrize(
    ("line", "sentence"),
    [
        ("knob.value -> lan.delay", "nothing says how far, which must be known before the start"),
        ("knob.value -> lan.round_trip_delay", "connect to lan.delay, which is that of each way"),
        ("knob.value -> lan.forward.reorder", "stays as it is while the scenario runs"),
        ("knob.value -> lan.dely", "nothing called 'dely'"),
        ("knob.value -> lan.loss via lan", "turns a channel; leave 'via' out"),
        ("lan.forward.age -> lan.loss", "what turns a channel is an output of a component"),
        ("coupler.force -> lan.loss", "coupler.force is in N and lan.forward.loss in 1"),
        ("knob.value -> knob.frequency", "only inputs, outputs, local variables and tunable"),
    ],
)
def test_a_connection(line: str, sentence: str, tmp_path: Path) -> None:
    text = HEAD + f"  - {line}\n"
    error = str(refusal(tmp_path, text))
    assert sentence in error
    assert ":12:" in error


@pytest.mark.parametrize(
    ("knob", "sentence"),
    [
        ("lan.delay: {}", "lan.forward.delay needs a 'maximum'"),
        ("lan.delay: {maximum: 0}", "lan.forward.delay cannot be 0.0078125 s: it goes from 0 s"),
        ("lan.delay: {maximum: 2 m}", "lan.delay"),
        ("coupler.stiffness: {minimum: 5, maximum: 1}", "the minimum, 5, is more than the maximum"),
        (
            "coupler.stiffness: {minimum: 5 kN/m}",
            "cannot be 1000 N/m: it goes from 5000 N/m",
        ),
        ("coupler.stiffness: {minimum: -5}", "the least that it can be is 0 N/m"),
        ("coupler.stifness: {}", "Did you mean stiffness"),
        ("couplr.stiffness: {}", "no component or channel 'couplr'"),
        ("coupler.stiffness: ~", "it has no value"),
        ("coupler.stiffness: {most: 1}", "unknown key 'most'"),
    ],
)
def test_a_knob(knob: str, sentence: str, tmp_path: Path) -> None:
    error = str(refusal(tmp_path, HEAD + f"knobs:\n  {knob}\n"))
    assert sentence in error
    assert ":13:" in error


@pytest.mark.parametrize(
    ("channel", "event", "sentence"),
    [
        ("loss={good_to_bad: 0.1, bad_to_good: 0.5}", "lan.loss: 1", "it comes in bursts"),
        ("jitter={rms: 1 ms}", "lan.jitter: 1", "its weights are no single number"),
        ("trace=[1, 2]", "lan.delay: 1", "'trace' stands in place of 'delay'"),
    ],
)
def test_a_channel_that_says_more_than_a_number(
    channel: str, event: str, sentence: str, tmp_path: Path
) -> None:
    text = HEAD + f"events:\n  - {{at: 0, set: {{{event}}}}}\n"
    if "trace" in channel:
        text = text.replace(", round_trip_delay: 1", "")
    error = str(refusal(tmp_path, text, (f"channels.lan.{channel}",)))
    assert "lan.forward" in error
    assert sentence in error


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"coupler.stiffness": -1}, "the least that it can be is 0 N/m"),
        ({"coupler.damping": 1}, "coupler.damping is no knob of this scenario: name it under 'kn"),
        ({"coupler.stiffness": 6e3}, "cannot be 6000 N/m: it goes from 0 N/m to 5000 N/m"),
        ({"lan.delay": 5}, "lan.forward.delay cannot be 0.0390625 s: it goes from 0 s to 0.031"),
        ({"lan.jitter": 1}, "lan.forward.jitter is no knob"),
        ({"nobody.x": 1}, "no component or channel 'nobody'"),
        ({"lan.delay": 2, "coupler.stiffness": "much"}, "much"),
        ({"knob.offset": 1}, "knob.offset is driven by"),
    ],
)
def test_by_hand(values: dict[str, Any], sentence: str, tmp_path: Path) -> None:
    """Nothing is turned where one of several cannot be."""
    text = HEAD.replace("via lan", "via lan\n  - user.force[1] -> knob.offset") + (
        "knobs: {coupler.stiffness: {maximum: 5000}, lan.delay: {maximum: 4}}\n"
    )
    with assemble(scenario_of(tmp_path, text)) as simulation:
        with pytest.raises(InputError) as refused:
            simulation.set(values)
        assert sentence in str(refused.value)
        simulation.run(MemorySink())
        assert simulation.replay() == simulation.scenario
