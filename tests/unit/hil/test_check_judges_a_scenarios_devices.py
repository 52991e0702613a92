"""``cohaptic check`` says what devices make of a scenario, before anything is opened."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.analysis.device_latency import latency_warnings
from cosim.base.errors import InputError, InputErrors
from cosim.cli import cli
from cosim.scenario import load


def overlay(folder, *fingers: str, keep=()):
    lines = ["components:"]
    for number, finger in enumerate(fingers):
        url = f"odrive+socketcan://can0?nodes={2 * number},{2 * number + 1}"
        lines.append(f'  {finger}: {{device: "{url}"}}')
        if finger not in keep:
            lines.append(f"  {finger.replace('finger', 'operator')}: ~")
    path = folder / "bench.yaml"
    path.write_text("\n".join(lines) + "\n")
    return path


def check(*arguments) -> str:
    return (
        CliRunner()
        .invoke(
            cli,
            ["check", *map(str, arguments)],
            catch_exceptions=False,
            standalone_mode=False,
        )
        .stdout
    )


def test_the_load_of_a_bus_is_printed(tmp_path):
    """Hand count: an ODrive axis has 8 + 4 bytes a tick, 47 bits of frame around each."""
    bench = overlay(tmp_path, "finger_a1", "finger_a2")
    report = json.loads(check("two_users_box", "--with", bench, "--json"))
    (bus,) = report["buses"]
    assert bus["devices"] == ["finger_a1", "finger_a2"]
    assert bus["load"] == pytest.approx(4 * (2 * 47 + 8 * 12) * 1024 / 1e6)
    assert "78% of 1 Mbit/s" in check("two_users_box", "--with", bench)


def test_a_bus_that_cannot_carry_the_scenario_is_refused_at_its_line(tmp_path):
    bench = overlay(tmp_path, "finger_a1", "finger_a2", "finger_b1")
    with pytest.raises(InputError, match=r"can0 cannot carry this: 116\.7%") as refused:
        check("two_users_box", "--with", bench)
    assert refused.value.location.file.endswith("bench.yaml")
    assert refused.value.location.line == 2


def test_a_scenario_without_devices_has_nothing_to_say():
    report = json.loads(check("two_users_box", "--json"))
    assert report["devices"] == {}
    assert report["buses"] == report["warnings"] == []


def test_gains_that_the_latency_unsettles_are_named(tmp_path):
    bench = overlay(tmp_path, "finger_a1")
    soft = json.loads(check("two_users_box", "--with", bench, "--json"))
    assert soft["warnings"] == []
    stiff = "components.vr_a.parameters.local_normal_stiffness=3000"
    warned = check("two_users_box", "--with", bench, "--set", stiff)
    assert "vr_a.local_normal_stiffness = 3000 N/m is unstable at the 1 tick of latency" in warned
    assert "finger_a1" in warned


@pytest.mark.parametrize(("stiffness", "unstable"), [(6430, False), (6440, True)])
def test_the_limit_is_the_thesis_s(stiffness: float, unstable: bool):
    """At b = 10 N.s/m one tick takes k_max from 20480 to 6434.7 N/m (hand 0.1, box 0.4 kg)."""
    values = {
        "local_normal_stiffness": stiffness,
        "local_normal_damping": 10,
        "hand_mass": 0.1,
        "mass": 0.4,
    }
    sets = [f"components.vr_a.parameters.{name}={value}" for name, value in values.items()]
    scenario = load("two_users_box", (), sets)
    local = [w for w in latency_warnings(scenario, {"finger_a1": 1}) if "normal" in w]
    assert bool(local) is unstable
    if unstable:
        assert "at most 6435 N/m at b = 10 N.s/m (without latency 20480)" in local[0]
    assert latency_warnings(scenario, {"finger_a1": 0}) == []


def test_what_only_a_simulation_knows_may_not_feed_control(tmp_path):
    """Directly, or through a channel; each at the connection's own line."""
    bench = overlay(tmp_path, "finger_a1", keep=("finger_a1",))
    with pytest.raises(InputErrors) as refused:
        check("two_users_box", "--with", bench)
    places = {error.location.line: error.message for error in refused.value.errors}
    assert len(places) == 2
    for line, message in places.items():
        assert refused.value.errors[0].location.file.endswith("two_users_box.yaml")
        assert line > 140
        assert "cannot measure tip_" in message
    bench.write_text(
        bench.read_text() + "connections:\n"
        "  - {remove: operator_a1.position}\n  - {remove: operator_a1.velocity}\n"
        "  - finger_a1.tip_position -> operator_b1.position via lan\n"
    )
    with pytest.raises(InputError, match=r"finger_a1 is a device, which cannot measure tip_pos"):
        check("two_users_box", "--with", bench)


SLOW = """
rates: {slow: 16 Hz}
components:
  finger_a1: {rate: slow, device: {url: "haply:///dev/nobody", preset: quanser}}
  operator_a1: ~
"""
SENTENCE = (
    "finger_a1 stays without output at 16 Hz: what fails there could not be dropped within 10 ms; "
    "control it at 300 Hz or faster"
)


def test_a_rate_too_slow_for_output_is_told(tmp_path):
    """A board of 16 Hz held its torque for 817 ms."""
    bench = tmp_path / "slow.yaml"
    bench.write_text(SLOW)
    report = json.loads(check("two_users_box", "--with", bench, "--json"))
    assert SENTENCE in report["warnings"]
    bench.write_text(SLOW.replace("16 Hz", "512 Hz"))
    report = json.loads(check("two_users_box", "--with", bench, "--json"))
    assert not any("without output" in warning for warning in report["warnings"])


@pytest.mark.parametrize("command", [["run", "--realtime"], ["station", "--as", "station_a"]])
def test_a_rate_too_slow_for_output_is_refused_before_anything_is_opened(tmp_path, command):
    bench = tmp_path / "slow.yaml"
    bench.write_text(SLOW)
    name, *options = command
    arguments = [name, "two_users_box", "--with", str(bench), *options, "--enable-output", "--yes"]
    ended = CliRunner().invoke(cli, [*arguments, "--out", str(tmp_path / "out")])
    assert isinstance(ended.exception, InputError)
    assert ended.exception.message == SENTENCE
    assert ended.exception.location.file.endswith("slow.yaml")
    assert not (tmp_path / "out").exists()
