"""A single-axis scenario is the loop that the theory analyses: read, run, and measured."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.base.recording import MemorySink
from cosim.cli import cli
from cosim.master.run.simulation import assemble
from cosim.scenario import load

AT_REST = ("components.step_1.parameters.amplitude=0",)


def theory(*arguments: str) -> dict[str, Any]:
    result = CliRunner().invoke(cli, ["theory", *arguments, "--json"], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def frames(scenario: str, sets: tuple[str, ...], signals: tuple[str, ...]) -> np.ndarray:
    """Signals of a co-simulated run at the frames' starts, shape (frames, signals)."""
    sink = MemorySink()
    with assemble(load(f"scenarios/{scenario}.yaml", sets=sets)) as simulation:
        simulation.run(sink)
    return np.column_stack([sink.signal(name)[::8] for name in signals])


def measured_radius(scenario: str, bodies: tuple[str, ...], sets: tuple[str, ...]) -> float:
    """The largest eigenvalue that a free motion shows: the linear map from three frames to the
    next three, fitted to velocities and relative positions (dynamic mode decomposition)."""
    kicks = [
        f"components.{body}.parameters.initial_velocity={speed}"
        for body, speed in zip(bodies, (0.1, -0.03, 0.05, 0.02), strict=False)
    ]
    signals = [f"{body}.{kind}" for kind in ("velocity", "position") for body in bodies]
    found = frames(scenario, (*AT_REST, *kicks, "duration=0.5 s", *sets), tuple(signals))
    velocity, position = found[:, : len(bodies)], found[:, len(bodies) :]
    shown = np.column_stack([velocity, position[:, 1:] - position[:, :1]])
    history = np.column_stack([shown[:-2], shown[1:-1], shown[2:]])
    before, after = history[:-1], history[1:]
    u, size, vh = np.linalg.svd(before, full_matrices=False)
    kept = size > 1e-10 * size[0]
    reduced = (u[:, kept] / size[kept]).T @ after @ vh[kept].T
    return float(np.max(np.abs(np.linalg.eigvals(reduced))))


@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_measured_spectral_radius_of_a_distributed_run(n: int) -> None:
    delay = f"channels.lan.round_trip_delay={n}"
    bodies = ("hand_1", "object_1", "object_2", "hand_2")
    found = theory("radius", "--scenario", "single_axis_distributed", "--set", delay)
    measured = measured_radius("single_axis_distributed", bodies, (delay,))
    assert measured == pytest.approx(found["spectral_radius"], rel=1e-5)


@pytest.mark.parametrize("n", [0, 1, 2])
def test_measured_spectral_radius_of_a_centralized_run(n: int) -> None:
    """800/3 for both users: stable without delay, unstable with it."""
    gains = [
        f"components.{coupler}.parameters.{name}={value}"
        for coupler in ("coupler_1", "coupler_2")
        for name, value in (("stiffness", 800), ("damping", 3))
    ]
    sets = (*gains, f"channels.lan.round_trip_delay={n}")
    settings = [part for text in sets for part in ("--set", text)]
    found = theory("radius", "--scenario", "single_axis_centralized", *settings)
    assert f"{found['spectral_radius']:.5f}" == ("0.96474", "1.19967", "1.27055")[n]
    measured = measured_radius("single_axis_centralized", ("hand_1", "object", "hand_2"), sets)
    assert measured == pytest.approx(found["spectral_radius"], rel=1e-5)


def test_measured_damping_is_the_theorys() -> None:
    """Pushed with 1 N for long, the hand ends up at 1/b, the force being held over every frame."""
    sets = ("components.step_1.parameters.start_time=0", "duration=8 s")
    speed = frames("single_axis_distributed", sets, ("hand_1.velocity",))[-1, 0]
    loop = ("damping", "--scenario", "single_axis_distributed")
    assert theory(*loop)["damping"] == pytest.approx(1 / speed, rel=1e-9)


def test_measured_damping_of_one_hand_alone_is_table_6_2() -> None:
    """User 2's hand held by nothing: the model of Fig. 6.1."""
    loose = [
        f"components.{coupler}.parameters.{name}=0"
        for coupler in ("coupler_22", "coupler_12")
        for name in ("stiffness", "damping")
    ]
    sets = (
        *loose,
        "channels.lan.round_trip_delay=0",
        "components.step_1.parameters.start_time=0",
        "duration=12 s",
    )
    speed = frames("single_axis_distributed", sets, ("hand_1.velocity",))[-1, 0]
    assert f"{1 / speed:.4g}" == "2.039"


def test_compensation_from_the_theory_nulls_the_damping_of_a_run() -> None:
    loop = ("damping", "--scenario", "scenarios/single_axis_distributed.yaml")
    null = theory(*loop)["compensation"]
    sets = [f"components.object_{m}.parameters.compensation={null}" for m in (1, 2)]
    sets += ["components.step_1.parameters.start_time=0", "duration=4 s"]
    v = frames("single_axis_distributed", tuple(sets), ("hand_1.velocity",))[:, 0]
    gained = np.diff(v[256:])
    # A mass under a constant force: the same gain in speed every frame.
    assert np.allclose(gained, gained.mean(), rtol=1e-6)
    assert gained.mean() > 0


def test_a_scenarios_loop_can_be_changed_by_name_and_by_path() -> None:
    loop = ("radius", "--scenario", "single_axis_distributed")
    by_name = theory(*loop, "--set", "k_11=2000", "--set", "b=10", "--round-trip-delay", "3")
    assert by_name["parameters"]["k_22"] == 2000
    assert by_name["parameters"]["b_o1"] == 10
    by_path = theory(*loop, "--set", "components.coupler_11.parameters.stiffness=2000")
    assert by_path["parameters"]["k_11"] == 2000
    assert by_path["parameters"]["k_22"] == 3000


def no_loop(folder: Path) -> Path:
    path = folder / "signal.yaml"
    path.write_text(
        "cohaptic: 1\ntitle: A signal\nduration: 1 s\nrates: {control: 1024 Hz}\n"
        "components:\n  one: {fmu: signal}\n"
    )
    return path


def test_planar_scenarios_are_asked_as_they_run() -> None:
    """Chapter 8's gains: the centralized twin is unstable at n = 1, the distributed grasp holds."""
    centralized = theory("radius", "--scenario", "two_users_box_centralized")
    assert not centralized["stable"]
    distributed = theory("modes", "--scenario", "two_users_box", "--count", "4")
    assert [mode["name"] for mode in distributed["modes"]] == ["carry", "lift", "turn", "squeeze"]
    assert all(mode["growth"] < 0 for mode in distributed["modes"])


def test_a_single_user_scenario() -> None:
    found = theory("boundary", "--scenario", "single_user", "--vary", "k", "--range", "1:50000")
    assert found["stable"][0][1] == pytest.approx(30720, abs=1e-6)


def test_delays_that_are_no_whole_samples_are_taken_as_they_are() -> None:
    def radius(forward: str) -> float:
        late = (
            "channels.lan={between: [station_1, station_2], rate: network, "
            f"delay: {{forward: {forward}, backward: 0}}}}"
        )
        loop = ("radius", "--scenario", "single_axis_distributed", "--set", late)
        return theory(*loop)["spectral_radius"]

    one, between, two = radius("1"), radius("10 ticks"), radius("2")
    assert len({one, between, two}) == 3
    assert between == pytest.approx(radius("'9.765625 ms'"), abs=1e-12)


def test_other_scenarios_and_contradictions_get_a_sentence(tmp_path: Path) -> None:
    def refusal(*arguments: str) -> str:
        with pytest.raises(InputError) as caught:
            CliRunner().invoke(
                cli, ["theory", *arguments], catch_exceptions=False, standalone_mode=False
            )
        return str(caught.value)

    assert "nothing that moves" in refusal("radius", "--scenario", str(no_loop(tmp_path)))
    assert "single-axis" in refusal("stiffness", "--scenario", str(no_loop(tmp_path)))
    loop = ("radius", "--scenario", "single_axis_distributed")
    assert "no scenario's" in refusal(*loop, "--architecture", "centralized")
    assert "no network" in refusal("radius", "--architecture", "single", "--ratio", "4")
    assert "--scenario" in refusal("radius", "--architecture", "single", "--with", "x.yaml")
