"""What people really write gives one sentence that says what to write, exactly where it stands."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from cosim.base.errors import InputError
from cosim.scenario import Scenario

TIME = "Write a time, such as 10, '2.44 ms' or '2 min'."
RATE = "Write a rate, such as 1024, '128 Hz' or '8192/3 Hz'."

# What is replaced in the small scenario, by what, and the one line that must come out.
BROKEN = {
    "a pattern of all": (
        "record: [left.*]",
        "record:\n  - *.position",
        "s.yaml:15:5: a pattern that begins with '*' needs quotes: '*.position'.",
    ),
    "a pattern of all, in brackets": (
        "[left.*]",
        "[left.*, *.joint_angle]",
        "s.yaml:14:18: a pattern that begins with '*' needs quotes: '*.joint_angle'.",
    ),
    "a star": (
        "[left.*]",
        "*",
        "s.yaml:14:9: a pattern that begins with '*' needs quotes: '*'.",
    ),
    "a question mark": (
        "[left.*]",
        "[?.x]",
        "s.yaml:14:11: text that begins with '?' needs quotes: '?.x'.",
    ),
    "no space behind ':' in braces": (
        "{base_x: 0.1}",
        "{base_x:0.1}",
        ("s.yaml:6:67: 'base_x:0.1' has no value; write a space behind ':', as in 'base_x: 0.1'."),
    ),
    "no space behind ':'": (
        "duration: 2 s",
        "duration:2 s",
        "s.yaml:3:1: write a space behind ':', as in 'duration: 2 s'.",
    ),
    "'=' for ':' in braces": (
        "{base_x: 0.1}",
        "{base_x=0.1}",
        "s.yaml:6:67: 'base_x=0.1' has no value; write ':' for '=', as in 'base_x: 0.1'.",
    ),
    "'=' for ':'": (
        "duration: 2 s",
        "duration = 2 s",
        "s.yaml:3:1: write ':' for '=', as in 'duration: 2 s'.",
    ),
    "no value in braces": (
        "{base_x: 0.1}",
        "{base_x}",
        "s.yaml:6:67: 'base_x' has no value; write 'base_x: value'.",
    ),
    "no space behind '-'": (
        "  - right.joint",
        "  -right.joint",
        (
            "s.yaml:13:3: write a space behind '-', as in "
            "'- right.joint_angle -> third.motor_torque'."
        ),
    ),
    "a comma for thousands, in braces": (
        "control: 1024",
        "control: 1,024",
        (
            "s.yaml:4:18: a number has no commas: '1,024' is written 1024, or 1.024 with a "
            "decimal point."
        ),
    ),
    "a comma for a decimal point": (
        "2 s",
        "2,5 s",
        (
            "s.yaml:3:11: duration: a number has no commas: '2,5' is written 25, or 2.5 with a "
            f"decimal point. {TIME}"
        ),
    ),
    "a comma inside braces": (
        "third: {fmu: pantograph",
        "third: {device: mock://x?a=1,b=2",
        ("s.yaml:8:19: inside {…} a text with a comma in it needs quotes: 'mock://x?a=1,b=2'."),
    ),
    "an open quote": (
        "title: Two",
        'title: "Two',
        's.yaml:2:8: the quote (") that opens here is never closed.',
    ),
    "an open quote before another": (
        "title: Two",
        "title: 'Two devices\nname: 'two",
        ("s.yaml:2:8: the quote that opens here closes only at the next one, where another opens."),
    ),
    "text behind a quote": (
        "title: Two devices",
        'title: "Two" devices',
        ("s.yaml:2:14: text goes on behind its closing quote; put all of it in quotes."),
    ),
    "an unknown escape": (
        "title: Two devices",
        'title: "C:\\Data"',
        (
            "s.yaml:2:12: in double quotes '\\' begins an escape; write '\\\\', or use single "
            "quotes."
        ),
    ),
    "an open brace": (
        "network: 128}",
        "network: 128",
        "s.yaml:4:8: the '{' that opens here is never closed; '}' is missing.",
    ),
    "an open brace at the end": (
        "{max_below: 1}}",
        "{max_below: 1}",
        "s.yaml:15:9: the '{' that opens here is never closed; '}' is missing.",
    ),
    "a bracket too many": (
        "[left.*]",
        "[left.*]]",
        "s.yaml:14:17: this ']' closes nothing.",
    ),
    "an index inside brackets": (
        "[left.*]",
        "[left.joint_angle[1]]",
        "s.yaml:14:26: a ',' or ']' is due before this '['; text with it needs quotes.",
    ),
    "a missing comma": (
        "control: 1024, network",
        "control: 1024 network",
        "s.yaml:4:30: a second ':' in one member; is a ',' or '}' missing before it?",
    ),
    "a comma too many": (
        "[left.*]",
        "[left.*,, right.*]",
        "s.yaml:14:17: a value is due before this ','.",
    ),
    "a tab for indentation": (
        "  right:",
        "\tright:",
        "s.yaml:7:1: a tab indents this line; YAML wants spaces.",
    ),
    "a percent sign": (
        "title: Two",
        "title: %Two",
        "s.yaml:2:8: text that begins with '%' needs quotes.",
    ),
    "an at sign": (
        "title: Two",
        "title: @Two",
        "s.yaml:2:8: text that begins with '@' needs quotes.",
    ),
    "a bar": (
        "title: Two",
        "title: |Two",
        "s.yaml:2:8: text that begins with '|' needs quotes.",
    ),
    "a control character": (
        "Two",
        "T\x07wo",
        "s.yaml:2:9: the control character U+0007 cannot stand here; delete it.",
    ),
    "a no-break space behind ':'": (
        "duration: 2 s",
        "duration:\u00a02 s",
        (
            "s.yaml:3:1: a key without ':'; it reads 'duration:\u00a02 s'. There is a no-break "
            "space in it; write a plain space."
        ),
    ),
    "a no-break space that indents": (
        "  right:",
        "\u00a0\u00a0right:",
        "s.yaml:7:1: a no-break space indents this line; YAML wants plain spaces.",
    ),
    "a wide colon": (
        "duration:",
        "duration：",
        (
            "s.yaml:3:1: a key without ':'; it reads 'duration： 2 s'. There is a wide colon in "
            "it; write ':'."
        ),
    ),
    "curly quotes": (
        "2 s",
        "“2 s”",
        (
            "s.yaml:3:11: duration: '“2 s”' is not a number with a unit. There is a curly quote "
            f"in it; write straight quotes or none. {TIME}"
        ),
    ),
    "a typographic minus": (
        "round_trip_delay: 1",
        "round_trip_delay: −1 ms",
        (
            "s.yaml:10:59: channels.lan.round_trip_delay: '−1 ms' is not a number with a unit. "
            "There is a typographic dash or minus in it; write '-'. Write a delay, such as 1 "
            "(samples), '2 ticks' or '2.44 ms'."
        ),
    ),
    "an octal number": (
        "duration: 2 s",
        "duration: 010",
        "s.yaml:3:11: '010' begins with 0, which some read as octal; write 10.",
    ),
    "minutes and seconds": (
        "2 s",
        "1:30",
        f"s.yaml:3:11: duration: '1:30' is not a number with a unit. {TIME}",
    ),
    "a date": (
        "2 s",
        "2026-01-02",
        f"s.yaml:3:11: duration: '2026-01-02' is not a number with a unit. {TIME}",
    ),
    "a unit in capitals": (
        "2 s",
        "2 mS",
        f"s.yaml:3:11: duration: 'mS' is not a unit known here. Did you mean ms? {TIME}",
    ),
    "a prefix in capitals": (
        "control: 1024",
        "control: 1 KHz",
        (f"s.yaml:4:18: rates.control: 'KHz' is not a unit known here. Did you mean kHz? {RATE}"),
    ),
    "a unit in words": (
        "2 s",
        "2 seconds",
        f"s.yaml:3:11: duration: 'seconds' is not a unit known here. Did you mean s? {TIME}",
    ),
    "a tag of Python": (
        "title: Two",
        "title: !!python/object:os.system Two",
        (
            "s.yaml:2:8: the tag '!!python/object:os.system' has no meaning in a scenario; leave "
            "it out."
        ),
    ),
    "a key twice": (
        "station: a, rate",
        "station: a, station: b, rate",
        "s.yaml:6:39: 'station' is here twice; it is first at s.yaml:6:27.",
    ),
    "on for true": (
        "third: {fmu: pantograph",
        "third: {fmu: pantograph, feedthrough: on",
        (
            "s.yaml:8:41: components.third.feedthrough: this must be true or false, not the text "
            "'on'; write true without quotes."
        ),
    ),
    "'True' as in Python, in quotes": (
        "third: {fmu: pantograph",
        "third: {fmu: pantograph, feedthrough: 'False'",
        (
            "s.yaml:8:41: components.third.feedthrough: this must be true or false, not the text "
            "'False'; write false without quotes."
        ),
    ),
    "true for a number": (
        "duration: 2 s",
        "duration: 2 s\nseed: True",
        "s.yaml:4:7: seed: this must be a whole number, not true.",
    ),
    "infinity for a time": (
        "2 s",
        ".inf",
        f"s.yaml:3:11: duration: .inf is not a finite number. {TIME}",
    ),
    "':' for '->'": (
        "right.joint_angle -> third",
        "right.joint_angle: third",
        (
            "s.yaml:13:5: connections.1: write 'right.joint_angle -> third.motor_torque', with "
            "'->' for ':'."
        ),
    ),
    "an arrow character": (
        "right.joint_angle -> third",
        "right.joint_angle → third",
        (
            "s.yaml:13:5: connections.1: 'right.joint_angle → third.motor_torque' is not a "
            "connection; write 'source.output -> target.input', with 'via CHANNEL', 'at RATE', "
            "'delay TIME' behind it. There is an arrow character in it; write '->'."
        ),
    ),
    "a parameter beside the model": (
        "rate: control, parameters: {base_x: 0.1}",
        "rate: control, mass: 0.2",
        "s.yaml:6:54: unknown key 'mass' in components.left. Did you mean parameters.mass?",
    ),
    "a key in capitals": (
        "duration:",
        "Duration:",
        "s.yaml:3:1: unknown key 'Duration'. Did you mean duration?",
    ),
    "a key in curly quotes": (
        "duration:",
        "“duration”:",
        (
            "s.yaml:3:1: unknown key '“duration”'. Did you mean duration? There is a curly "
            "quote in it; write straight quotes or none."
        ),
    ),
    "a pattern in curly quotes": (
        "[left.*]",
        "[“left.*”]",
        (
            "s.yaml:14:10: there is no component '“left'. Did you mean left? There is a curly "
            "quote in it; write straight quotes or none."
        ),
    ),
    "a list without spaces": (
        "record: [left.*]",
        "record:\n  -left.*",
        (
            "s.yaml:15:3: record: this must be a list, not the text '-left.*'; write "
            "'- left.*', with a space."
        ),
    ),
    "one item for a list": (
        "record: [left.*]",
        "record: left.*",
        "s.yaml:14:9: record: this must be a list, not the text 'left.*'; write [left.*].",
    ),
    "a list of components": (
        (
            "  left: {fmu: pantograph, station: a, rate: control, parameters: {base_x: 0.1}}\n"
            "  right: {fmu: pantograph, station: b, rate: control}\n"
            "  third: {fmu: pantograph, station: b, rate: control}\n"
        ),
        "  - left: {fmu: pantograph, station: a, rate: control}\n",
        (
            "s.yaml:6:3: components: this must be a mapping ('key: value' lines), not a list; "
            "take the '-' or the brackets away."
        ),
    ),
    "no rates at all": (
        "rates: {control: 1024, network: 128}",
        "rates: [1024, 128]",
        (
            "s.yaml:4:8: rates: this must be a mapping ('key: value' lines), not a list; take "
            "the '-' or the brackets away."
        ),
    ),
    "a list of channels": (
        "  lan: {between",
        "  - lan: {between",
        (
            "s.yaml:10:3: channels: this must be a mapping ('key: value' lines), not a list; "
            "take the '-' or the brackets away."
        ),
    ),
    "a component whose kind is unknown": (
        "right: {fmu: pantograph",
        "right: {fum: pantograph",
        "s.yaml:7:11: unknown key 'fum' in components.right. Did you mean fmu?",
    ),
}

ACCEPTED = {
    "a tab behind ':'": ("duration: 2 s", "duration:\t2 s"),
    "a tab inside a value": ("duration: 2 s", "duration: 2\ts"),
    "a tab behind '-'": ("  - right", "  -\tright"),
    "a tab before a comment": ("duration: 2 s", "duration: 2 s\t# two"),
    "a tab behind a value": ("duration: 2 s", "duration: 2 s\t"),
    "tabs on an empty line": ("duration: 2 s", "duration: 2 s\n\t\t"),
    "a tab in braces": ("{base_x: 0.1}", "{base_x:\t0.1}"),
    "an exponent without a point": ("control: 1024, network: 128", "control: 1e3, network: 125"),
    "a unit behind a no-break space": ("2 s", "2\u00a0s"),
    "a unit that is glued": ("2 s", "2s"),
    "Windows line ends": ("\n", "\r\n"),
    "a byte-order mark": ("cohaptic:", "\ufeffcohaptic:"),
    "curly quotes in a title": ("title: Two", "title: “Two”"),
}


@pytest.mark.parametrize("mistake", BROKEN)
def test_a_mistake_gives_its_sentence(
    mistake: str, small: str, scenario_of: Callable[..., Scenario]
) -> None:
    old, new, sentence = BROKEN[mistake]
    assert old in small
    with pytest.raises(InputError) as caught:
        scenario_of(small.replace(old, new, 1))
    assert str(caught.value) == sentence


@pytest.mark.parametrize("way", ACCEPTED)
def test_what_is_legal_is_read(way: str, small: str, scenario_of: Callable[..., Scenario]) -> None:
    old, new = ACCEPTED[way]
    assert old in small
    scenario = scenario_of(small.replace(old, new, -1 if old == "\n" else 1))
    assert scenario.duration == 2
    assert len(scenario.connections) == 2
