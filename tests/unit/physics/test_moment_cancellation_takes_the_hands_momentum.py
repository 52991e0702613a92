"""A finger that hits the box gets floor(m v / (T F)) impulses, fewer once it stops approaching."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from tests.support.physics.planar_oracle import Bench, T

CANCELLING, PRE_SLIDE = 1, 2
HAND = 0.1


def rigid_box(force: float) -> Bench:
    return Bench(
        "distributed_workstation",
        [(0.0, 0.06)],
        peers=0,
        mass=1e9,
        inertia=1e9,
        moment_cancellation=True,
        hand_mass=HAND,
        **{"finger_1.max_force": force},
    )


@settings(deadline=None, max_examples=25)
@given(speed=st.floats(0.02, 0.5), force=st.floats(0.5, 3.0))
def test_as_many_impulses_as_the_momentum_asks_for(speed: float, force: float) -> None:
    """The finger is led at a constant speed, so that nothing ends the impulses early."""
    exact = HAND * speed / (T * force)
    assume(abs(exact - round(exact)) > 1e-6)
    wanted = math.floor(exact)
    bench, y = rigid_box(force), 0.05 + 3.3 * speed * T
    given_impulses = 0
    for _ in range(wanted + 40):
        y -= speed * T
        if y < -0.04:
            break
        bench.put((0.0, y))
        if bench["finger_1.contact_state"] == CANCELLING:
            given_impulses += 1
            assert bench["finger_1.force"] == pytest.approx([0.0, force], abs=1e-12)
        bench.step()
    assert given_impulses == wanted


def test_impulses_end_as_soon_as_the_finger_recedes() -> None:
    bench, y = rigid_box(2.5), 0.0512
    states = []
    for tick in range(12):
        y += -0.4 * T if tick < 8 else 0.05 * T
        bench.put((0.0, y))
        states.append(bench["finger_1.contact_state"])
        bench.step()
    assert states[7] == CANCELLING
    assert states[8:] == [PRE_SLIDE] * 4


def free_flight(*, cancel: bool) -> tuple[float, int]:
    """Deepest penetration (m) and lost contacts of a free hand hitting a rigid box at 0.25 m/s."""
    bench = rigid_box(2.5)
    bench.instance.initialise(moment_cancellation=cancel)
    y, v, deepest = 0.055, -0.25, 0.0
    for _ in range(400):
        bench.put((0.0, y))
        f = bench["finger_1.force"][1] - 0.3
        bench.step()
        y, v = y + T * v + 0.5 * T * T * f / HAND, v + T * f / HAND
        deepest = max(deepest, 0.05 - y)
    return deepest, bench["finger_1.contact_losses"]


def test_a_hand_that_hits_is_stopped_sooner_with_impulses() -> None:
    with_impulses, without = free_flight(cancel=True), free_flight(cancel=False)
    assert with_impulses[0] < 0.8 * without[0]
    assert with_impulses[1] <= without[1]


def test_box_and_hand_keep_their_momentum() -> None:
    """The impulses act on both: what the hand loses the box has."""
    bench = rigid_box(2.5)
    bench.instance.initialise(mass=0.4, ground_friction=0.0, integration=2)
    y, v, states = 0.0512, -0.3, set()
    for _ in range(60):
        bench.put((0.0, y))
        states.add(bench["finger_1.contact_state"])
        f = bench["finger_1.force"][1]
        bench.step()
        y, v = y + T * v + 0.5 * T * T * f / HAND, v + T * f / HAND
    total = HAND * v + 0.4 * bench["box_velocity.y"]
    assert total == pytest.approx(-0.3 * HAND, rel=1e-9)
    assert CANCELLING in states
