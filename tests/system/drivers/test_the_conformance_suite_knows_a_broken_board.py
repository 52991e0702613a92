"""Every shipped emulator and the C firmware conform; a board that breaks a rule is told of it."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from hil.device.errors import ActivationRefused
from hil.safety.permission import ask, emulated
from hil.setup.address import parse
from hil.setup.calibrate.turner import EmulatedTurner
from hil.setup.conform.bench import ConformBench
from hil.setup.conform.rule import Conformity
from hil.setup.conform.suite import RULES, chosen, conform
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find
from tests.support.hil.driver_bench import DRIVERS, PROOF, SETUPS, Bench
from tests.support.hil.motor_process import motors
from tests.support.hil.mutants import MUTANTS, mutant

NOT_TRIED = {
    "haply": {"clock", "switch", "bits", "cuts", "junk", "nan", "watchdog", "rearm"},
    "cobs": set(),
    "odrive": {"clock", "switch", "bits", "cuts", "junk"},
    "cia402": {"clock", "switch", "bits", "cuts", "junk"},
    "canopen": {"clock", "switch", "bits", "cuts", "junk"},
}
"""What says nothing about a protocol; everything else is tried, and kept."""


def on(emulator, name: str, document: dict) -> ConformBench:
    kind = find(name)
    return ConformBench(
        kind=kind,
        address=parse(emulator.url),
        file=parse_file({"driver": name, "home": list(emulator.home), **document}),
        turner=EmulatedTurner(str(emulator.control.path)),
        ask=None,
        control=emulator.control,
        permission=emulated(emulator.url, None),
        seconds=0.5,
    )


@pytest.mark.parametrize("name", DRIVERS)
def test_every_emulator_conforms(name: str, bench: Bench):
    emulator = bench.emulator(name)
    driver = SETUPS[name].get("driver", name)
    results = {each.name: each for each in conform(on(emulator, driver, SETUPS[name]["file"]))}
    assert list(results) == [rule.name for rule in RULES]
    broken = [each for each in results.values() if each.outcome is Conformity.BROKEN]
    assert broken == []
    skipped = {each.name for each in results.values() if each.outcome is Conformity.NOT_TRIED}
    assert skipped == NOT_TRIED[driver]


def test_every_rule_has_a_board_that_breaks_it():
    known = {name.partition(" ")[0] for name in MUTANTS} | {"owner", "counts"}
    assert known == {rule.name for rule in RULES}


@pytest.mark.parametrize("name", MUTANTS)
def test_a_board_that_breaks_a_rule_is_told_of_it(name: str):
    with mutant(name) as board:
        made = on(board, "cobs", {"watchdog_proof": PROOF})
        (result,) = conform(made, chosen([name.partition(" ")[0]], RULES))
    assert result.outcome is Conformity.BROKEN, result
    assert len(result.sentence) > 20


def test_a_driver_that_locks_nothing_is_told_of_it(bench: Bench, monkeypatch):
    emulator = bench.emulator("cobs")
    made = on(emulator, "cobs", SETUPS["cobs"]["file"])
    monkeypatch.setattr("hil.wire.serial_port.own_port", lambda *_: None)
    monkeypatch.setattr("hil.wire.serial_port.PATIENCE", 1.0)
    (result,) = conform(made, chosen(["owner"], RULES))
    assert result.outcome is Conformity.BROKEN, result


def test_a_file_with_another_encoder_is_told_of_it(bench: Bench, monkeypatch):
    emulator = bench.emulator("cobs")
    made = on(emulator, "cobs", SETUPS["cobs"]["file"])
    real = "hil.drivers.cobs.driver.sample_of_counts"

    def doubled(joints, count, sequence):
        from hil.drivers.samples import sample_of_counts

        sample = sample_of_counts(joints, count, sequence)
        return type(sample)(
            shaft_angle=(2 * sample.shaft_angle[0], sample.shaft_angle[1]),
            count=count,
            sequence=sequence,
        )

    monkeypatch.setattr(real, doubled)
    (result,) = conform(made, chosen(["counts"], RULES))
    assert result.outcome is Conformity.BROKEN, result


def invoke(*arguments: str):
    return CliRunner().invoke(
        cli, ["device", "conform", *arguments], catch_exceptions=False, standalone_mode=False
    )


def test_the_command_says_what_became_of_each_rule(bench: Bench, tmp_path):
    emulator = bench.emulator("cobs")
    path = tmp_path / "device.yaml"
    path.write_text(json.dumps({"driver": "cobs", "home": list(emulator.home)}))
    options = ("--file", str(path), "--seconds", "0.2", "--yes")
    done = invoke(emulator.url, *options)
    assert done.exit_code == 0
    assert "not tried watchdog" in done.stdout
    assert "give --enable-output" in done.stdout
    done = invoke(emulator.url, *options, "--enable-output", "--only", "watchdog", "--json")
    (rule,) = json.loads(done.stdout)["rules"]
    assert (rule["name"], rule["outcome"]) == ("watchdog", "kept")
    with pytest.raises(InputError, match="did you mean 'watchdog'"):
        invoke(emulator.url, *options, "--only", "watchdgo")


def test_a_real_board_needs_a_person():
    with motors("cobs") as board, pytest.raises(ActivationRefused, match="a person has to"):
        invoke(f"cobs://{board.port}", "--yes")


def test_a_broken_rule_is_status_1(tmp_path):
    with mutant("zero") as board:
        done = invoke(board.url, "--only", "zero", "--yes")
    assert done.exit_code == 1
    assert "no answer confirmed zero torque" in done.stdout


def test_a_real_board_without_a_watchdog_is_not_made_active_here(bench: Bench):
    """No supervisor guards this command: the rule says so, and the board is not called broken."""
    emulator = bench.emulator("haply")
    made = on(emulator, "haply", SETUPS["haply"]["file"])
    made.permission = ask("haply", [], lambda _: "enable")
    (result,) = conform(made, chosen(["reset"], RULES))
    assert result.outcome is Conformity.NOT_TRIED
    assert "no supervisor guards this process" in result.sentence
