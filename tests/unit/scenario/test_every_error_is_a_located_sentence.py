"""Each kind of mistake gives one sentence with file, line, column, and what to do."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cosim.base.errors import InputError, InputErrors
from cosim.scenario import Scenario

# What is replaced in the small scenario, by what, and the one line that must come out.
MISTAKES = {
    "no version": (
        "cohaptic: 1\n",
        "",
        (
            "s.yaml:1:1: the first line of a scenario is 'cohaptic: 1', the version of its "
            "language; "
            "it is missing."
        ),
    ),
    "another version": (
        "cohaptic: 1",
        "cohaptic: 2",
        (
            "s.yaml:1:11: version 2 of the scenario language; this cohaptic reads version 1. Write "
            "'cohaptic: 1' or install a newer one."
        ),
    ),
    "unknown key": (
        "duration: 2 s",
        "duration: 2 s\nsede: 1",
        "s.yaml:4:1: unknown key 'sede'. Did you mean seed?",
    ),
    "unknown key of a component": (
        "station: a",
        "staton: a",
        "s.yaml:6:27: unknown key 'staton' in components.left. Did you mean station?",
    ),
    "missing key": ("duration: 2 s\n", "", "s.yaml:1:1: the scenario needs 'duration'."),
    "wrong type": (
        "title: Two devices and a network",
        "title: [x]",
        "s.yaml:2:8: title: this must be a text, not a list.",
    ),
    "unknown unit": (
        "2 s",
        "2 parsec",
        (
            "s.yaml:3:11: duration: 'parsec' is not a unit known here. Write a time, such as 10, "
            "'2.44 ms' or '2 min'."
        ),
    ),
    "unit of something else": (
        "2 s",
        "2 Hz",
        (
            "s.yaml:3:11: duration: '2 Hz' is in Hz, which does not convert to s. Write a time, "
            "such "
            "as 10, "
            "'2.44 ms' or '2 min'."
        ),
    ),
    "not above zero": (
        "2 s",
        "0 s",
        "s.yaml:3:11: duration: 0 s is out of range: more than 0 s and at most 10000000 s.",
    ),
    "a rate that does not fit": (
        "network: 128",
        "network: 100",
        (
            "s.yaml:4:33: the rate network (100 Hz) does not fit: with it, one period of the rate "
            "control (1024 Hz) would be 25 base ticks (at most 8). The nearest rate that fits is "
            "102.4 Hz; or write 'base_rate: 25600 Hz' to have the finer tick."
        ),
    ),
    "a rate that does not fit the base rate": (
        "rates:",
        "base_rate: 1536\nrates:",
        (
            "s.yaml:5:18: the rate control (1024 Hz) does not fit base_rate, 1536 Hz, which "
            "must be a "
            "whole multiple of it. The nearest rate that fits is 768 Hz."
        ),
    ),
    "unknown rate": (
        "station: a, rate: control",
        "station: a, rate: contrl",
        "s.yaml:6:45: there is no rate 'contrl'. Did you mean control?",
    ),
    "no rate among several": (
        "station: a, rate: control",
        "station: a",
        "s.yaml:6:3: components.left needs a 'rate' (one of control, network).",
    ),
    "unknown model": (
        "left: {fmu: pantograph",
        "left: {fmu: pantogrph",
        (
            "s.yaml:6:15: components.left: no bundled FMU is called 'pantogrph'. Did you mean "
            "pantograph? A file needs a path that ends in .fmu."
        ),
    ),
    "no kind": (
        "left: {fmu: pantograph, ",
        "left: {",
        (
            "s.yaml:6:3: components.left: it has no kind; give it one of 'fmu', 'python', "
            "'device', 'playback' or 'table'."
        ),
    ),
    "two kinds": (
        "left: {fmu: pantograph,",
        "left: {fmu: pantograph, device: 'mock://',",
        "s.yaml:6:3: components.left: one kind too many: fmu and device; keep one of them.",
    ),
    "a key of another kind": (
        "third: {fmu: pantograph",
        "third: {device: 'mock://', substeps: 2",
        "s.yaml:8:3: components.third: 'substeps' belongs to 'fmu', not to 'device'.",
    ),
    "no URL": (
        "third: {fmu: pantograph",
        "third: {device: haply",
        (
            "s.yaml:8:19: components.third: 'haply' is no device URL; write 'driver://port', "
            "such as "
            "'mock://'."
        ),
    ),
    "no class": (
        "third: {fmu: pantograph",
        "third: {python: model.py",
        (
            "s.yaml:8:19: components.third: 'model.py' is no Python class; write "
            "'package.module:Class' or 'file.py:Class', or the name of one that a package "
            "has registered."
        ),
    ),
    "bad name": (
        "  third:",
        "  3rd: {fmu: pantograph, rate: control}\n  third:",
        (
            "s.yaml:8:3: components.3rd: the text '3rd' is no name: letters, digits and '_', a "
            "letter "
            "first."
        ),
    ),
    "a name of two things": (
        "channels:\n",
        "channels:\n  left: {between: [a, b], rate: network}\n",
        "s.yaml:10:3: 'left' is a component already.",
    ),
    "an end without components": (
        "between: [a, b]",
        "between: [a, c]",
        "s.yaml:10:22: no component is in the station 'c'. There are a and b.",
    ),
    "both ends the same": (
        "between: [a, b]",
        "between: [a, a]",
        "s.yaml:10:18: both ends are the station a.",
    ),
    "three ends": (
        "between: [a, b]",
        "between: [a, b, c]",
        "s.yaml:10:18: channels.lan.between: this list must have at most 2 items, not 3.",
    ),
    "two forms of delay": (
        "round_trip_delay: 1",
        "round_trip_delay: 1, each_way_delay: 1",
        (
            "s.yaml:10:3: channels.lan: the delay is given twice: round_trip_delay and "
            "each_way_delay; keep one of them."
        ),
    ),
    "half a delay": (
        "round_trip_delay: 1",
        "delay: {forward: 1}",
        "s.yaml:10:48: channels.lan.delay needs 'backward'.",
    ),
    "half a sample": (
        "round_trip_delay: 1",
        "round_trip_delay: 1.5",
        (
            "s.yaml:10:59: channels.lan.round_trip_delay: 1.5 is not a whole number of samples; "
            "write "
            "a time, such as '2.44 ms', and it is rounded up to base ticks."
        ),
    ),
    "negative delay": (
        "round_trip_delay: 1",
        "round_trip_delay: -1 ms",
        (
            "s.yaml:10:59: channels.lan.round_trip_delay: -1 ms is out of range: a delay is at "
            "least 0 "
            "and at most 10000000."
        ),
    ),
    "no probability": (
        "round_trip_delay: 1",
        "loss: 2",
        (
            "s.yaml:10:47: channels.lan.loss: 2 is not a probability: it is from 0 to 1 ('20 %' is "
            "0.2)."
        ),
    ),
    "no probability in a burst": (
        "round_trip_delay: 1",
        "loss: {forward: {good_to_bad: 2, bad_to_good: 1}, backward: 0}",
        (
            "s.yaml:10:71: channels.lan.loss.forward.good_to_bad: 2 is not a probability: it is "
            "from 0 "
            "to 1 ('20 %' is 0.2)."
        ),
    ),
    "a chain that is stuck": (
        "round_trip_delay: 1",
        "loss: {good_to_bad: 0, bad_to_good: 0}",
        (
            "s.yaml:10:47: channels.lan.loss: good_to_bad and bad_to_good are both 0: the chain is "
            "stuck."
        ),
    ),
    "a trace that is not there": (
        "round_trip_delay: 1",
        "trace: packets.csv",
        "s.yaml:10:48: channels.lan.trace: cannot read packets.csv: No such file or directory.",
    ),
    "a trace beside a loss": (
        "round_trip_delay: 1",
        "trace: [1], loss: 0.1",
        "s.yaml:10:3: channels.lan: 'trace' stands in place of 'loss'; keep one of them.",
    ),
    "no connection": (
        "right.joint_angle -> third.motor_torque",
        "right.joint_angle, third.motor_torque",
        (
            "s.yaml:13:5: connections.1: 'right.joint_angle, third.motor_torque' is not a "
            "connection; "
            "write 'source.output -> target.input', with 'via CHANNEL', 'at RATE', 'delay TIME' "
            "behind "
            "it."
        ),
    ),
    "an unknown clause": (
        "third.motor_torque",
        "third.motor_torque through lan",
        (
            "s.yaml:13:5: connections.1: 'through lan' is not understood; write 'source.output -> "
            "target.input', with 'via CHANNEL', 'at RATE', 'delay TIME' behind it."
        ),
    ),
    "an end without a variable": (
        "-> third.motor_torque",
        "-> third",
        "s.yaml:13:5: connections.1.to: the text 'third' is no signal; write component.variable.",
    ),
    "an unknown component": (
        "-> third.motor_torque",
        "-> thrid.motor_torque",
        (
            "s.yaml:13:5: there is no component 'thrid' (right.joint_angle -> thrid.motor_torque). "
            "Did you mean third?"
        ),
    ),
    "an unknown channel": (
        "via lan",
        "via lann",
        "s.yaml:12:5: there is no channel 'lann'. Did you mean lan?",
    ),
    "stations without a channel": (
        " via lan",
        "",
        (
            "s.yaml:12:5: left.joint_angle -> right.motor_torque goes from the station a to b "
            "without "
            "a channel; add 'via lan'."
        ),
    ),
    "a channel inside a station": (
        "third.motor_torque\n",
        "third.motor_torque via lan\n",
        (
            "s.yaml:13:5: right.joint_angle -> third.motor_torque stays inside the station b; "
            "leave "
            "'via' out."
        ),
    ),
    "a delay beside a channel": (
        "via lan",
        "via lan delay 1",
        "s.yaml:12:5: the delay is the channel's; give it to channels.lan.",
    ),
    "two connections into one input": (
        "right.joint_angle -> third",
        "right.joint_angle -> right",
        "s.yaml:13:5: a second connection into right.motor_torque; the first is at s.yaml:12:5.",
    ),
    "what a channel knows, at the wrong end": (
        "right.joint_angle -> third.motor_torque",
        "lan.backward.age -> third.motor_torque",
        (
            "s.yaml:13:5: lan.backward.age is known in the station a, where the packets arrive; "
            "third.motor_torque is in b."
        ),
    ),
    "an unknown signal to record": (
        "[left.*]",
        "[lfet.*]",
        "s.yaml:14:10: there is no component 'lfet'. Did you mean left?",
    ),
    "an expectation of nothing": (
        "{left.energy:",
        "{lfet.energy:",
        "s.yaml:15:10: there is no component 'lfet'. Did you mean left?",
    ),
    "a duplicate key": (
        "title:",
        "duration: 1\ntitle:",
        "s.yaml:4:1: 'duration' is here twice; it is first at s.yaml:2:1.",
    ),
    "a tab": (
        "  right:",
        "\tright:",
        "s.yaml:7:1: a tab indents this line; YAML wants spaces.",
    ),
    "an open bracket": (
        "record: [left.*]",
        "record: [left.*",
        "s.yaml:14:9: the '[' that opens here is never closed; ']' is missing.",
    ),
    "an unknown anchor": (
        "title: Two devices and a network",
        "title: *name",
        "s.yaml:2:8: there is no anchor '&name' before this '*name'.",
    ),
    "a tag": (
        "title: Two",
        "title: !python/object Two",
        "s.yaml:2:8: the tag '!python/object' has no meaning in a scenario; leave it out.",
    ),
    "an include that is not there": (
        "title:",
        "include: nothing.yaml\ntitle:",
        "s.yaml:2:10: there is no file nothing.yaml and no bundled scenario of that name.",
    ),
    "an include of itself": (
        "title:",
        "include: s.yaml\ntitle:",
        "s.yaml:2:10: files include each other: s.yaml -> s.yaml.",
    ),
    "yes for true": (
        "third: {fmu: pantograph",
        "third: {fmu: pantograph, feedthrough: yes",
        (
            "s.yaml:8:41: components.third.feedthrough: this must be true or false, not the text "
            "'yes'; write true without quotes."
        ),
    ),
    "an archive that does not exist": (
        "third: {fmu: pantograph",
        "third: {fmu: 1",
        "s.yaml:8:16: components.third.fmu: this must be a text, not 1.",
    ),
    "an unknown flavour": (
        "third: {fmu: pantograph",
        "third: {fmu: pantograph, flavour: fmi4",
        (
            "s.yaml:8:37: components.third.flavour: this must be 'fmi2', 'fmi3' or "
            "'fmi3-arrays', not "
            "the text 'fmi4'. Did you mean fmi3?"
        ),
    ),
    "an empty value": (
        "title: Two devices and a network",
        "title:",
        "s.yaml:2:1: title: it has no value.",
    ),
    "a parameter twice": (
        "{base_x: 0.1}",
        "{f: {x: 1}, f.x: 2}",
        "s.yaml:6:83: 'f.x' is here twice; it is first at s.yaml:6:74.",
    ),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_gives_its_sentence(
    mistake: str, small: str, scenario_of: Callable[..., Scenario]
) -> None:
    old, new, sentence = MISTAKES[mistake]
    assert small.count(old) >= 1
    with pytest.raises(InputError) as caught:
        scenario_of(small.replace(old, new, 1))
    assert str(caught.value) == sentence
    assert caught.value.exit_status == 2


def test_all_mistakes_are_reported_at_once_in_file_order(
    small: str, scenario_of: Callable[..., Scenario]
) -> None:
    broken = (
        small.replace("duration: 2 s", "duration: soon")
        .replace("parameters:", "paramters:")
        .replace("round_trip_delay: 1", "round_trip_delay: 1, loss: 7")
        .replace("third.motor_torque", "fourth.motor_torque")
        .replace("[left.*]", "[up.*]")
    )
    with pytest.raises(InputErrors) as caught:
        scenario_of(broken)
    places = [str(error.location) for error in caught.value.errors]
    assert places == ["s.yaml:3:11", "s.yaml:6:54", "s.yaml:10:68", "s.yaml:13:5", "s.yaml:14:10"]
    assert str(caught.value).count("\n") == 4


def test_a_file_that_is_no_text_or_no_mapping(
    scenario_of: Callable[..., Scenario], tmp_path
) -> None:
    for text, sentence in {
        "": "s.yaml:1:1: a scenario file is a mapping, 'key: value' lines.",
        "- a": "s.yaml:1:1: a scenario file is a mapping, 'key: value' lines.",
        "just text": "s.yaml:1:1: a scenario file is a mapping, 'key: value' lines.",
        "[" * 1000: "s.yaml:1:1: nested too deeply to be a scenario.",
        "a: &a [*a]": "s.yaml:1:4: the anchor &a contains itself.",
    }.items():
        with pytest.raises(InputError) as caught:
            scenario_of(text)
        assert str(caught.value) == sentence
    from cosim.scenario import load

    (tmp_path / "binary.yaml").write_bytes(b"a: \xff\xfe")
    with pytest.raises(InputError, match=r"binary.yaml:1:1: not UTF-8 text \(byte 3\)"):
        load("binary.yaml")
    with pytest.raises(InputError, match="is a folder, not a scenario file"):
        load(".")


def test_aliases_that_explode_are_refused(scenario_of: Callable[..., Scenario]) -> None:
    lines = ["x-0: &x0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"x-{i}: &x{i} [{', '.join([f'*x{i - 1}'] * 10)}]" for i in range(1, 10)]
    with pytest.raises(InputError, match="more than 100000 values"):
        scenario_of("\n".join(lines))
