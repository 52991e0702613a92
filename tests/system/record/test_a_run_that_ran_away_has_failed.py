"""Finite numbers that no bench can reach are told, with status 1; an expectation takes over."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.cli import cli

DIVERGES = """\
cohaptic: 1
duration: 0.8 s
rates: {control: 1024, network: 128}
components:
  pull: {fmu: signal, station: a, rate: control, parameters: {mode: step, amplitude: 1}}
  hand: {fmu: hand, station: a, rate: control}
  coupler: {fmu: virtual_coupler, station: b, rate: control}
channels:
  lan: {between: [a, b], rate: network, round_trip_delay: 1}
connections:
  - pull.value -> hand.force
  - hand.position -> coupler.position_a via lan
  - hand.velocity -> coupler.velocity_a via lan
  - coupler.reaction -> hand.coupler_force via lan
record: [hand.position]
"""


def run(folder: Path, text: str) -> tuple[int, dict[str, object]]:
    file = folder / "s.yaml"
    file.write_text(text)
    result = CliRunner().invoke(
        cli, ["run", str(file), "--out", str(folder / "run"), "--no-figure", "--json"]
    )
    return result.exit_code, json.loads(result.stdout)


def test_the_signal_the_time_and_the_size_are_told(tmp_path: Path) -> None:
    status, summary = run(tmp_path, DIVERGES)
    assert status == 1
    (said,) = summary["runaways"]
    assert said.startswith("hand.position ran away: beyond 100 m since t = 0.")


@pytest.mark.parametrize("stiffness", [100])
def test_a_calm_run_says_nothing(tmp_path: Path, stiffness: float) -> None:
    calm = DIVERGES.replace(
        "rate: control}\nchannels",
        f"rate: control, parameters: {{stiffness: {stiffness}, damping: 1}}}}\nchannels",
    )
    assert calm != DIVERGES
    status, summary = run(tmp_path, calm)
    assert (status, summary["runaways"]) == (0, [])


def test_who_expects_it_is_the_judge(tmp_path: Path) -> None:
    status, summary = run(tmp_path, DIVERGES + "expect: {hand.position: {max_abs_above: 100}}\n")
    assert (status, summary["runaways"], summary["passed"]) == (0, [], True)


@pytest.mark.parametrize("limit", ["max_abs_above: 1", "min_below: 1e9 km", "max_above: 99 m"])
def test_who_expects_something_else_is_not(limit: str, tmp_path: Path) -> None:
    status, summary = run(tmp_path, DIVERGES + f"expect: {{hand.position: {{{limit}}}}}\n")
    if "km" in limit:  # a scale of its own, stated
        assert (status, summary["passed"]) == (0, True)
        return
    assert (status, summary["passed"]) == (1, False)
    assert "hand.position ran away" in summary["failures"][0]
    assert len(summary["runaways"]) == 1


def test_nothing_recorded_is_said_and_runs(tmp_path: Path) -> None:
    text = DIVERGES.replace("record: [hand.position]", "record: []")
    status, summary = run(tmp_path, text)
    assert (status, summary["ticks"], summary["signals"]) == (0, 820, {})
    manifest = json.loads((tmp_path / "run" / "manifest.json").read_text())
    assert any("nothing is recorded" in note for note in manifest["notes"])
