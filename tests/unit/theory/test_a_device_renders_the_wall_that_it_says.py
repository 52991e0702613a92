"""The Z-width of a scenario's device: rule and eigenvalues of the device, walls of the kernel.

Set beforehand: with nothing but the sampling left of the device, walls of three quarters of what
eigenvalues say come to rest in the kernel (a difference is half a tick late), and 5 % above do not;
so with a tick of delay by the rule. Dry friction lets stiffer walls rest than the rule allows.
"""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.analysis.answers.rendered_wall import WallOfDevice, find_device
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


def test_the_command_says_whose_wall_it_is() -> None:
    found = CliRunner().invoke(command, ["--scenario", BOX, "--most", "3", "--json"])
    assert found.exit_code == 0, found.output
    answer = json.loads(found.stdout)
    assert answer["device"]["count"] == pytest.approx(41.4e-6, rel=1e-2)
    assert len(answer["z_width"]) == 8
    assert all(0.0 < row["as_built"] < 3 * row["by_rule"] for row in answer["z_width"])
