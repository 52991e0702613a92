"""A finger is pushed out of the box, never pulled in, and friction stays inside its cone."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fmus.shared.world.couplers import TABLE_8_1
from tests.support.physics.planar_oracle import Bench, T

FREE, PRE_SLIDE, SLIDE = 0, 2, 3


@st.composite
def wander(draw: st.DrawFn) -> list[tuple[float, float]]:
    """A finger path (m) around the top edge of a box of 0.1 m, at up to 0.5 m/s."""
    x, y = draw(st.floats(-0.04, 0.04)), draw(st.floats(0.045, 0.055))
    path = []
    for _ in range(draw(st.integers(5, 12))):
        vx, vy = draw(st.floats(-0.5, 0.5)), draw(st.floats(-0.3, 0.2))
        for _ in range(6):
            x, y = np.clip(x + T * vx, -0.045, 0.045), np.clip(y + T * vy, 0.035, 0.06)
            path.append((float(x), float(y)))
    return path


@settings(deadline=None, max_examples=30)
@given(path=wander(), static=st.floats(0.2, 1.0), ratio=st.floats(0.3, 1.0))
def test_forces_on_a_free_box(path: list[tuple[float, float]], static: float, ratio: float) -> None:
    bench = Bench(
        "distributed_workstation",
        [(0.0, 0.05)],
        peers=0,
        static_friction=static,
        kinetic_friction=ratio * static,
    )
    for place in path:
        bench.put(place)
        normal, tangential = bench["finger_1.normal_force"], bench["finger_1.tangential_force"]
        assert normal >= 0.0
        assert abs(tangential) <= static * normal * (1 + 1e-12)
        if bench["finger_1.contact_state"] == SLIDE:
            assert abs(abs(tangential) - ratio * static * normal) <= 1e-12
        force, box = bench["finger_1.force"], bench.planar("box_pose")
        assert np.hypot(*force) <= np.hypot(normal, tangential) * (1 + 1e-12)
        arm = bench["finger_1.position"] - box[:2]
        moment = arm[0] * -force[1] - arm[1] * -force[0]
        np.testing.assert_allclose(
            bench.planar("finger_wrench"), [-force[0], -force[1], moment], rtol=0, atol=1e-13
        )
        bench.step()


def held_box(**parameters: float) -> Bench:
    """A box too heavy to move, its top face at y = 0.05."""
    return Bench(
        "distributed_workstation", [(0.0, 0.05)], peers=0, mass=1e9, inertia=1e9, **parameters
    )


def test_normal_force_is_the_spring_and_the_damper() -> None:
    bench = held_box()
    stiffness, damping = TABLE_8_1[:2]
    for depth in (0.001, 0.002, 0.0035):
        bench.put((0.0, 0.05 - depth))
        speed = bench["finger_1.velocity"][1]
        expected = stiffness * depth - damping * speed
        assert abs(bench["finger_1.normal_force"] - expected) < 1e-9
        assert bench["finger_1.contact_face"] == 2
        bench.step()


def test_a_finger_that_leaves_fast_is_let_go_and_not_pulled() -> None:
    bench = held_box()
    bench.put((0.0, 0.048))
    bench.step()
    bench.put((0.0, 0.0495))
    assert bench["finger_1.contact_state"] == PRE_SLIDE
    assert bench["finger_1.normal_force"] == 0.0
    bench.step()
    bench.put((0.0, 0.0505))
    assert bench["finger_1.contact_state"] == FREE
    assert bench["finger_1.contact_losses"] == 1


def test_the_entry_face_is_kept_until_the_exit() -> None:
    bench = held_box()
    for x in np.linspace(0.0, 0.049, 40):
        bench.put((x, 0.047))
        assert bench["finger_1.contact_face"] == 2
        bench.step()
    bench.put((0.051, 0.047))
    assert bench["finger_1.contact_face"] == 0
    assert bench["finger_1.contact_losses"] == 1


def test_resticking_is_bumpless() -> None:
    bench = held_box(slide_threshold=0.02)
    x, forces, states = -0.03, [], []
    for speed in [*np.linspace(0.2, 0.0, 60), *[0.0] * 10]:
        x += speed * T
        bench.put((x, 0.045))
        forces.append(bench["finger_1.tangential_force"])
        states.append(bench["finger_1.contact_state"])
        bench.step()
    slides = [k for k, state in enumerate(states) if state == SLIDE]
    again = slides[-1] + 1
    assert states[again:] == [PRE_SLIDE] * len(states[again:])
    assert abs(forces[again] - forces[again - 1]) < 1e-9
    # From there on only the damper's force fades, at most b times the threshold.
    assert np.ptp(forces[again:]) <= TABLE_8_1[3] * 0.02 + 1e-9


def test_a_slow_push_drags_the_anchor_at_the_edge_of_the_cone() -> None:
    bench = held_box(slide_threshold=0.05)
    x = -0.02
    for _ in range(1500):
        x += 0.01 * T
        bench.put((x, 0.045))
        limit = 0.6 * bench["finger_1.normal_force"]
        force, state = bench["finger_1.tangential_force"], bench["finger_1.contact_state"]
        bench.step()
        assert state == PRE_SLIDE
        assert abs(force) <= limit * (1 + 1e-12)
    assert abs(force) > 0.999 * limit


def test_opposed_fingers_at_rest_bring_no_energy() -> None:
    """Held fingers and a released box: kinetic energy never exceeds what the springs held."""
    rng = np.random.default_rng(5)
    stiffness = TABLE_8_1[0]
    for _ in range(15):
        depths, offsets = rng.uniform(0.0005, 0.004, 2), rng.uniform(-0.02, 0.02, 2)
        bench = Bench(
            "distributed_workstation",
            [(0.0, 0.05), (0.0, -0.05)],
            [0.0, np.pi],
            peers=0,
            ground_friction=0.0,
            ground_rotational_friction=0.0,
        )
        bench.put((offsets[0], 0.05 - depths[0]), (offsets[1], -0.05 + depths[1]))
        stored = 0.5 * stiffness * np.sum(depths**2)
        for _ in range(600):
            bench.step()
            assert bench["box_energy"] <= stored
        assert bench["box_energy"] < 0.01 * stored
