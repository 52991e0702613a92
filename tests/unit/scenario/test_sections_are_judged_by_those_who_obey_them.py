"""Sections of a scenario are read by the forms of those who obey them, all problems at once."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError, InputErrors
from cosim.cli import cli
from cosim.reading import FORMS
from cosim.scenario import load
from cosim.scenario.resolved import to_yaml

BROKEN = """cohaptic: 1
duration: 1
components:
  a: {fmu: operator, rate: 1000, station: s}
  b: {fmu: operator, rate: 1000, station: t}
channels:
  lan: {between: [s, t], rate: 1000, link: {fade: 3 m}}
safety: {torque: 1 V, sle: 3}
realtime: {on_miss: wait, cpu: 1.5}
link: {relase: arrival}
expect:
  a.x: {max_abs_belo: 3}
  a.y: {from: true, max_within: 3}
  a.z: {w: {frequency: fast, final_equals: 1 xyz, man_below: 2}}
"""

BENCH = """cohaptic: 1
duration: 1
rates: {control: 1000}
components: {left: {device: 'mock://'}, right: {device: 'mock://'}}
"""


def test_every_section_says_what_is_wrong_and_where(tmp_path) -> None:
    file = tmp_path / "broken.yaml"
    file.write_text(BROKEN)
    with pytest.raises(InputErrors) as caught:
        load(file, forms=FORMS)
    told = [str(error).removeprefix(f"{file}:") for error in caught.value.errors]
    said = "\n".join(told)
    assert [line.split(": ")[0] for line in told] == [
        *("7:51", "8:18", "8:23", "9:21", "9:32", "10:8"),
        *("12:3", "13:15", "13:33", "14:24", "14:51"),
    ], said
    for sentence in (
        "'3 m' is in m, which does not convert to s",
        "'1 V' is in V, which does not convert to N.m",
        "unknown key 'sle' in safety. Did you mean slew?",
        "unknown key 'relase' in link. Did you mean release?",
        "max_abs_belo is not a predicate. Did you mean max_abs_below?",
        "Did you mean mean_below?",
    ):
        assert sentence in said


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ("cohaptic: '1'", "write 'cohaptic: 1', without quotes"),
        ("record:", "record: it has no value"),
        ("record: [~]", "record.0: it has no value"),
        ("record: [{signals: ~}]", "record.0.signals: it has no value"),
    ],
)
def test_what_looks_like_a_value_and_is_none(changed, sentence, tmp_path) -> None:
    file = tmp_path / "bench.yaml"
    key = changed.partition(":")[0]
    lines = [line for line in BENCH.splitlines() if not line.startswith(f"{key}:")]
    file.write_text("\n".join([*lines, changed]))
    with pytest.raises(InputError, match=sentence):
        load(file)


def test_an_anchor_cannot_be_set_but_its_copies_can() -> None:
    copies = "--set components.vr_a.parameters.mass=1 and --set components.vr_b.parameters.mass=1"
    with pytest.raises(InputError, match=f"write {copies}"):
        load("two_users_box", (), ["x-environment.mass=1"])
    with pytest.raises(InputError, match="where the alias stands"):
        load("two_users_box", (), ["x-nothing.mass=1"])


def test_weights_that_do_not_sum_to_one_are_refused() -> None:
    with pytest.raises(InputError, match=r"the weights sum to 0\.7; they are probabilities"):
        load("two_users_box", (), ["channels.lan.jitter={weights: [0.5, 0.2]}"])


def test_the_package_reads_as_the_commands_do(tmp_path) -> None:
    import cohaptic

    file = tmp_path / "bench.yaml"
    file.write_text(f"{BENCH}safety: {{torque: 1 V}}\n")
    with pytest.raises(InputError, match=r"does not convert to N\.m"):
        cohaptic.load(file)


def test_sections_are_in_si_units_and_survive_their_own_writing(tmp_path) -> None:
    sets = ("safety.torque='100 mN.m'", "link.fade='20 ms'", "realtime={on_miss: stop, cpu: 0}")
    scenario = load("two_users_box", (), sets, forms=FORMS)
    assert scenario.safety == {"torque": 0.1}
    assert scenario.link["fade"] == 0.02
    written = tmp_path / "again.yaml"
    written.write_text(to_yaml(scenario))
    again = load(written, forms=FORMS)
    sections = ("safety", "link", "realtime", "expect")
    assert [getattr(again, name) for name in sections] == [
        getattr(scenario, name) for name in sections
    ]


@pytest.mark.parametrize(("torque", "holds"), [(0.05, 0.05), (0.5, 0.15)])
def test_the_tighter_of_safety_and_device_holds_for_every_device(torque, holds, tmp_path) -> None:
    file = tmp_path / "bench.yaml"
    file.write_text(BENCH)
    done = CliRunner().invoke(
        cli, ["check", str(file), "--set", f"safety.torque={torque}", "--json"]
    )
    devices = json.loads(done.stdout)["devices"]
    limits = devices["left"]["file"]["limits"]
    assert devices["right"]["file"]["limits"] == limits
    assert limits["torque"] == {"value": holds, "from": "safety" if holds == torque else "device"}
    assert limits["slew"] == {"value": 60.0, "from": "device"}
