"""The Z-width of a scenario's device: rule and eigenvalues of the device, walls of the kernel.

Set beforehand: with nothing but the sampling left of the device, walls of three quarters of what
eigenvalues say come to rest in the kernel (a difference is half a tick late), and 5 % above do not;
so with a tick of delay by the rule. Dry friction lets stiffer walls rest than the rule allows.
"""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.analysis.answers.device_of_wall import find_device
from cosim.analysis.answers.rendered_wall import WallOfDevice
from cosim.base.errors import InputError
from cosim.cli.theory.robust.z_width import command
from cosim.scenario.load import read
from cosim.theory.robust.z_width import by_eigenvalues, by_rule

BOX = "two_users_box"
DEVICE, STATION = "components.finger_a1.parameters", "components.vr_a.parameters"
IDEAL = [
    *(f"{DEVICE}.{name}=0" for name in ("encoder_counts", "dac_bits", "coulomb_friction")),
    *(f"{DEVICE}.{name}=0" for name in ("torque_limit", "current_limit", "amplifier_bandwidth")),
    f"{STATION}.velocity_estimator=finite_difference",
    f"{STATION}.velocity_window=1",
]


def wall(sets: list[str]) -> WallOfDevice:
    written = read(BOX, (), sets)
    return WallOfDevice(written, find_device(written.built(), "finger_a1", 0))


def test_what_sampling_alone_leaves_is_what_eigenvalues_say() -> None:
    with wall(IDEAL) as device:
        facts = device.facts
        assert facts.count == 0.0
        # The finger's 60 g and the device: the thesis's 0.1 kg of hand and device together.
        assert facts.mass == pytest.approx(0.1, rel=0.05)
        wanted = [by_eigenvalues(facts, one) for one in (2.0, 6.0)]
        for one, limit in zip((2.0, 6.0), wanted, strict=True):
            assert device.rests(0.75 * limit, one)
            assert not device.rests(1.05 * limit, one)


def test_a_tick_of_delay_costs_what_the_rule_says() -> None:
    with wall([*IDEAL, f"{DEVICE}.computation_delay_ticks=1"]) as device:
        assert device.facts.delay == 1
        limit = by_rule(device.facts, 4.0)
        assert limit == pytest.approx((4.0 + device.facts.damping) / (1.5 / 1024))
        assert device.rests(0.7 * limit, 4.0)
        assert not device.rests(1.1 * limit, 4.0)


def test_dry_friction_of_the_joints_lets_stiffer_walls_rest() -> None:
    with wall([f"{DEVICE}.coulomb_friction=0"]) as smooth, wall([]) as dry:
        assert dry.facts == smooth.facts
        stiffness = 1.25 * by_rule(dry.facts, 2.5)
        assert dry.rests(stiffness, 2.5)
        assert not smooth.rests(stiffness, 2.5)


def test_counts_at_the_tip_are_those_of_the_encoders() -> None:
    with wall([f"{DEVICE}.encoder_counts=2000"]) as coarse, wall([]) as fine:
        assert coarse.facts.count == pytest.approx(10 * fine.facts.count, rel=1e-6)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--scenario", BOX, "--mass", "1"], "--mass describes a device, and two_users_box has"),
        (["--scenario", BOX, "--window", "4"], "--window describes a device"),
        (["--scenario", BOX, "--count", "0"], "--count describes a device"),
        (["--scenario", BOX, "--finger", "finger_a"], "Did you mean finger_a"),
        (["--scenario", "single_axis_distributed"], "no pantograph"),
        (["--finger", "finger_a1"], "give --scenario FILE too"),
        (["--axis", "y"], "give --scenario FILE too"),
        (["--set", "a.b=1"], "give --scenario FILE too"),
    ],
)
def test_what_a_scenario_fixes_is_no_option(options: list[str], said: str) -> None:
    found = CliRunner().invoke(command, options)
    assert isinstance(found.exception, InputError)
    assert said in str(found.exception)


def _told() -> str:
    """The connection that tells finger_a1 its forces."""
    wires = read(BOX).built().connections
    return f"connections.{[str(wire.target) for wire in wires].index('finger_a1.device')}"


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (["components.finger_a1.feedthrough=false"], "finger_a1 has its own 'feedthrough'"),
        (["components.vr_a.feedthrough=false"], "vr_a has its own 'feedthrough'"),
        (["components.finger_a1.substeps=4"], "finger_a1 has its own 'substeps'"),
        (["components.finger_a1.rate=512 Hz"], "finger_a1 has its own 'rate'"),
        (
            [f"{_told()}={{from: vr_a.finger_1, to: finger_a1.device, factor: 2}}"],
            "is delayed, sampled, scaled",
        ),
        (
            [f"{_told()}=vr_a.finger_1 -> finger_a1.device delay 1 ticks"],
            "is delayed, sampled, scaled",
        ),
    ],
)
def test_a_device_that_steps_or_is_joined_otherwise_is_refused(sets: list[str], said: str) -> None:
    with pytest.raises(InputError, match=said):
        find_device(read(BOX, (), sets).built(), "finger_a1", 0)


def test_a_finger_whose_forces_are_computed_elsewhere_renders_no_wall_of_its_own() -> None:
    scenario = read("two_users_box_centralized").built()
    assert find_device(scenario, "finger_a1", 0).station.name == "server"
    with pytest.raises(InputError, match="client is told the forces of finger_b1"):
        find_device(scenario, "finger_b1", 0)


def test_a_device_that_is_told_nothing_renders_nothing() -> None:
    wires = read(BOX).built().connections
    kept = [repr(str(wire)) for wire in wires if str(wire.target) != "finger_a1.device"]
    written = read(BOX, (), ["connections=~", f"connections=[{', '.join(kept)}]"])
    with pytest.raises(InputError, match=r"Nothing goes from vr_a\.finger_1 to finger_a1"):
        find_device(written.built(), "finger_a1", 0)


def test_the_command_says_whose_wall_it_is() -> None:
    found = CliRunner().invoke(command, ["--scenario", BOX, "--most", "3", "--json"])
    assert found.exit_code == 0, found.output
    answer = json.loads(found.stdout)
    assert answer["device"]["count"] == pytest.approx(41.4e-6, rel=1e-2)
    assert len(answer["z_width"]) == 8
    assert all(0.0 < row["as_built"] < 3 * row["by_rule"] for row in answer["z_width"])
