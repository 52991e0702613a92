"""What an emulated device is made of changes how it moves, or how it is homed: every key does."""

from __future__ import annotations

import pytest

from hil.emulation.launch import Order, make
from hil.emulation.mechanics import HeldForm, Mechanics

CHANGES = {
    "payload": 0.05,
    "proximal_inertia": 1e-4,
    "distal_mass": 0.02,
    "distal_inertia": 1e-5,
    "tip_mass": 0.03,
    "coulomb_friction": 0.001,
    "viscous_friction": 1e-3,
    "delay": 2,
    "torque_gain": [1.2, 0.8],
    "noise": 1e-3,
    "hand": HeldForm(stiffness=0.0, damping=0.0),
}


NOBODY = HeldForm(stiffness=0.0, damping=0.0)


def moved(mechanics: Mechanics, **more: float) -> tuple[float, float]:
    parameters = {"device": 1, "initial_tip_position": (0.019, 0.1), **more}
    order = Order(name="haply", lockstep=True, parameters=parameters, mechanics=mechanics)
    board, link, _ = make(order)
    board.world.torque = (0.03, -0.02)
    for _ in range(60):
        board.world.advance()
    angle = board.world.angle()
    board.world.body.close()
    link.close()
    return angle


@pytest.fixture(scope="module")
def usual():
    return moved(Mechanics())


@pytest.mark.parametrize("name", CHANGES)
def test_it_moves_otherwise(name, usual):
    assert moved(Mechanics(**{name: CHANGES[name]})) != pytest.approx(usual, abs=1e-6)


def test_a_handle_that_nobody_holds_carries_no_hand():
    """The pantograph carries a hand's mass by itself, which would be taken for the device's."""
    free = moved(Mechanics(hand=NOBODY))
    assert free == moved(Mechanics(hand=NOBODY, payload=0.0))
    assert free != pytest.approx(moved(Mechanics(hand=NOBODY, payload=0.06)), abs=1e-3)


def test_a_mass_that_is_given_stays_though_nobody_holds_it():
    given = moved(Mechanics(hand=NOBODY), finger_mass=0.05)
    assert given == moved(Mechanics(hand=NOBODY, payload=0.05))


def test_it_is_homed_with_its_error():
    assert Mechanics(home_error=[0.01, -0.02]).homed((1.0, 2.0)) == pytest.approx((1.01, 1.98))


def test_there_is_no_key_besides():
    assert {*CHANGES, "home_error"} == {*Mechanics.model_fields}
