"""Perceived admittance: its limits, its two definitions, and time simulation as the oracle."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.theory.models.assembly import assemble
from cosim.theory.models.frame import Frame
from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.transparency.admittance import Case, Felt, default_parameters, perceived
from cosim.theory.transparency.damping import limit_damping
from cosim.theory.transparency.stiffness import equivalent_stiffness

ONE = Timing(delay=PathDelay.round_trip(1))


def response(felt: Felt, case: Case, *frequencies: float):
    return perceived(default_parameters(felt), ONE, felt, case, np.array(frequencies))


@pytest.mark.parametrize(("felt", "user"), [("remote", 1), ("distributed", 0)])
def test_low_frequencies_feel_the_limit_damping(felt: Felt, user: int) -> None:
    model = default_parameters(felt).model((user == 0, user == 1))
    found = response(felt, "free", 1e-4)
    assert abs(found.frame_lifted[0]) == pytest.approx(
        1 / limit_damping(model, ONE, user), rel=1e-5
    )


def test_the_local_user_and_the_ideal_feel_a_mass() -> None:
    for felt in ("local", "ideal"):
        found = response(felt, "free", 0.1)
        assert found.fundamental[0] == pytest.approx(1 / (0.1j * 0.5), rel=1e-3)


def test_the_compensated_user_feels_no_damping_but_more_than_one_mass() -> None:
    found = response("compensated", "free", 0.01)
    impedance = 1 / found.fundamental[0]
    assert abs(impedance.real) < 1e-3 * abs(impedance)
    assert 0.7 < impedance.imag / 0.01 < 0.8


@pytest.mark.parametrize(("felt", "user"), [("local", 0), ("remote", 1), ("distributed", 0)])
def test_pressing_slowly_feels_the_equivalent_stiffness(felt: Felt, user: int) -> None:
    parameters = default_parameters(felt).replaced({"k_w": 30000.0, "b_w": 20.0})
    stiffness = equivalent_stiffness(parameters.model((user == 0, user == 1)), user)
    found = response(felt, "contact", 1e-3)
    assert abs(found.frame_lifted[0]) == pytest.approx(1 / stiffness, rel=1e-4)
    assert abs(found.fundamental[0]) == pytest.approx(1 / stiffness, rel=1e-4)


def simulate(frame: Frame, frequency: float, seconds: float, *, each_tick: bool) -> np.ndarray:
    """The hand's velocity at every tick under cos(ωt), sampled and held, from rest."""
    state = np.zeros(frame.map.shape[0])
    m = frame.tick.shape[0]
    memory = frame.map[m:]
    velocities = []
    for index in range(round(seconds / frame.control_period / frame.samples)):
        inside, held = state[:m], frame.held_effect @ (frame.held @ state)
        for k in range(frame.samples):
            now = index * frame.samples + (k if each_tick else 0)
            velocities.append(inside[frame.hand[0] + 1])
            force = np.cos(frequency * now * frame.control_period)
            inside = frame.tick @ inside + held + frame.force_on_hand[0] * force
        state = np.concatenate([inside, memory @ state])
    return np.array(velocities)


@pytest.mark.parametrize("frequency", [5.0, 80.0])
def test_both_definitions_are_what_a_simulation_settles_to(frequency: float) -> None:
    parameters = Parameters("distributed", {}, TABLE_6_1["distributed"])
    frame = assemble(parameters.model((True, False)), ONE).frame()
    found = perceived(parameters, ONE, "distributed", "free", np.array([frequency]))
    # Correlate over whole periods, after the transient.
    settle, period = 5.0, 2 * np.pi / frequency
    seconds = settle + 40 * period
    for each_tick, expected in ((True, found.fundamental[0]), (False, found.frame_lifted[0])):
        velocity = simulate(frame, frequency, seconds, each_tick=each_tick)
        step = frame.control_period * (1 if each_tick else frame.samples)
        sampled = velocity if each_tick else velocity[:: frame.samples]
        time = np.arange(sampled.size) * step
        kept = time >= settle
        basis = np.column_stack([np.cos(frequency * time[kept]), -np.sin(frequency * time[kept])])
        (real, imaginary), *_ = np.linalg.lstsq(basis, sampled[kept], rcond=None)
        assert complex(real, imaginary) == pytest.approx(expected, rel=1e-2)


def test_frequencies_have_to_be_ones_that_the_loop_can_follow() -> None:
    with pytest.raises(InputError, match="positive"):
        response("local", "free", 0.0)
    with pytest.raises(InputError, match="half the control rate"):
        response("local", "free", 4000.0)
