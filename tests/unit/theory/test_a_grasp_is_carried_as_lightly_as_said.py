"""The damping of a grasp is what its drift needs in the kernel, and the compensation nulls it.

Set beforehand: with the force that is said a drift keeps its speed for 40 network periods to 1e-4,
and without it slows down; with the compensation it keeps its speed without a force, with a fifth
less of it slows down and with a fifth more speeds up, by as much within a tenth.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from cosim.analysis.answers.asked import AskedRun, ask
from cosim.analysis.answers.grasp_damping import (
    Carriers,
    Drift,
    carried,
    carriers,
    compensation_sets,
    null_grasp_damping,
    released,
)
from cosim.analysis.compensation import tuned
from cosim.analysis.monodromy.point import Point, find_point
from cosim.cli.theory.damping import command
from cosim.scenario.load import read

BOX, SERVER = "two_users_box", "two_users_box_centralized"
PERIODS = 40
SPEED = 1e-5


def speed_after(point: Point, drift: Drift, axis: int, hands: Carriers | None) -> float:
    """The box's speed after a while, of that at the start; with the hands' force, or without."""
    run = point.run
    place = next(
        number
        for number, one in enumerate(run.coordinates)
        if one.name == f"environment.box.velocity.{'xy'[axis]}"
    )
    run.undisturbed()
    ends = [run.start + sign * SPEED * drift.state[:, axis] for sign in (1.0, -1.0)]
    first = float((ends[0] - ends[1])[place])
    for _ in range(PERIODS):
        for number, sign in enumerate((1.0, -1.0)):
            run.put(ends[number])
            for along in range(2) if hands is not None else ():
                force = sign * SPEED * drift.damping[along, axis] / len(hands.operators)
                for push in hands.pushes[along]:
                    name, variable = push.source
                    was = run.output(name, variable)
                    run.fmus[name].overwrite({variable: was + force})
            run.simulation.advance(run.tick + run.hyperperiod)
            ends[number] = run.numbers()
    return float((ends[0] - ends[1])[place]) / first


def drifting(asked: AskedRun, b_c: np.ndarray) -> Point:
    sets = [*released(asked.point()), *compensation_sets(asked.scenario, b_c)]
    return find_point(asked.written.changed(sets), None, asked.point())


@pytest.mark.slow
@pytest.mark.parametrize("name", [BOX, SERVER])
def test_the_force_that_is_said_keeps_a_drift_going(name: str) -> None:
    sets = [] if name == BOX else ["components.server.parameters.remote_normal_stiffness=170"]
    with ask(read(name, (), sets)) as asked:
        hands = carriers(asked.scenario, None)
        with drifting(asked, np.zeros(2)) as point:
            drift = carried(point, hands)
            for axis in range(2):
                assert drift.damping[axis, axis] > 0.01
                assert speed_after(point, drift, axis, hands) == pytest.approx(1.0, abs=1e-4)
                assert speed_after(point, drift, axis, None) < 0.995


@pytest.mark.slow
def test_with_less_than_the_compensation_a_drift_slows_and_with_more_it_grows() -> None:
    with ask(read(BOX)) as asked:
        hands = carriers(asked.scenario, None)
        found = null_grasp_damping(asked, None)
        b_c = np.array([found.compensation[axis] for axis in "xy"])
        assert found.verdict == "stable"
        assert (b_c < 0.0).all()
        speeds: list[float] = []
        for share in (0.8, 1.0, 1.2):
            with drifting(asked, share * b_c) as point:
                speeds.append(speed_after(point, carried(point, hands), 0, None))
        slower, same, faster = speeds
        assert same == pytest.approx(1.0, abs=1e-4)
        assert slower < 0.999
        assert faster > 1.001
        assert np.log(faster) == pytest.approx(-np.log(slower), rel=0.1)


def answer(*options: str) -> dict[str, Any]:
    done = CliRunner().invoke(command, [*options, "--json"], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


@pytest.mark.slow
def test_the_command_answers_for_a_planar_run_and_for_a_remote_user() -> None:
    found = answer("--scenario", SERVER, "--set", "channels.lan.round_trip_delay=0")
    assert found["user"] == ["operator_b1", "operator_b2"]
    assert set(found["damping"]) == set(found["compensation"]) == {"x", "y"}


def compensated(choice: str, ticks: int) -> float:
    sets = [
        "channels.lan.round_trip_delay=~",
        f"channels.lan.delay={{forward: {ticks} ticks, backward: 0}}",
        *(f"components.vr_{which}.parameters.compensation={choice}" for which in "ab"),
    ]
    part = tuned(read(BOX, (), sets)).built().components["vr_a"]
    value = part.parameters["compensation.x"]
    assert isinstance(value, float)
    return value


def test_only_a_cautious_compensation_rounds_down() -> None:
    none, most, sample = (compensated("auto", ticks) for ticks in (0, 6, 8))
    assert sample < most < none
    none, most, sample = (compensated("cautious", ticks) for ticks in (0, 6, 8))
    assert most == none != sample
