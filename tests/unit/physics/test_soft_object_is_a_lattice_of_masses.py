"""The soft object moves as masses on springs do, keeps momentum, and is held like the box."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Array, Bench, T

MASS, SIDE, STIFFNESS, DAMPING = 0.4, 0.1, 800.0, 0.5
INERTIA = 6.7e-4
OUTER = INERTIA / (3 * SIDE**2)
MASSES = np.array([*[OUTER] * 4, MASS - 8 * OUTER, *[OUTER] * 4])
FREE = {"environment": 1, "ground_friction": 0.0, "peers": 0}


def nodes(bench: Bench) -> Array:
    return np.asarray(bench["node_position"]).reshape(9, 2)


def springs() -> list[tuple[int, int]]:
    """All pairs of neighbours, diagonal ones included."""
    cells = [(row, column) for row in range(3) for column in range(3)]
    return [
        (i, j)
        for i, a in enumerate(cells)
        for j, b in enumerate(cells)
        if i < j and max(abs(a[0] - b[0]), abs(a[1] - b[1])) == 1
    ]


def test_lattice_has_twenty_springs() -> None:
    assert len(springs()) == 20


def spring_forces(x: Array, v: Array) -> Array:
    rest = [(SIDE / 2 * np.array([i % 3 - 1, i // 3 - 1])) for i in range(9)]
    force = np.zeros_like(x)
    for i, j in springs():
        length = np.linalg.norm(x[j] - x[i])
        along = (x[j] - x[i]) / length
        pull = STIFFNESS * (length - np.linalg.norm(rest[j] - rest[i]))
        pull += DAMPING * (v[j] - v[i]) @ along
        force[i] += pull * along
        force[j] -= pull * along
    return force


def test_a_finger_on_a_node_drives_the_lattice_as_an_independent_one() -> None:
    """Pushed at the middle of its upper side, where the whole force meets one mass."""
    bench = Bench("distributed_workstation", [(0.0, 0.05)], **FREE)
    x, v, thinnest = nodes(bench), np.zeros((9, 2)), SIDE
    for tick in range(300):
        bench.put((0.0, 0.05 - min(1e-4 * tick, 0.006)))
        force = bench["finger_1.force"]
        # Pushed on one node it buckles, which makes more of every rounding.
        np.testing.assert_allclose(nodes(bench), x, rtol=0, atol=1e-9)
        total = spring_forces(x, v)
        total[7] -= force
        v = v + T * total / MASSES[:, None]
        x = x + T * v
        thinnest = min(thinnest, float(np.linalg.norm(x[7] - x[1])))
        bench.step()
    assert thinnest < SIDE - 5e-4
    assert x[4, 1] < -0.001


def run(angle: float, ticks: int = 250) -> tuple[Array, Array, Bench]:
    """Two fingers squeeze, shear and let go in a turned world; nodes by tick."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    places = [(0.013, 0.05), (-0.009, -0.05)]
    bench = Bench(
        "distributed_workstation",
        [tuple(turn @ p) for p in places],
        **{**FREE, "initial_box_pose.theta": angle},
    )
    out, forces = [], []
    for tick in range(ticks):
        depth = 0.006 * np.sin(np.pi * min(tick / 150, 1.1)) - 0.001
        sway = 0.004 * np.sin(0.04 * tick)
        bench.put(*(turn @ [x + sway, y - np.sign(y) * depth] for x, y in places))
        out.append(nodes(bench) @ turn)
        forces.append([turn.T @ bench[f"finger_{f}.force"] for f in (1, 2)])
        bench.step()
    return np.array(out), np.array(forces), bench


@pytest.mark.parametrize("angle", [0.8, -2.5])
def test_a_turned_world_does_the_same(angle: float) -> None:
    plain, turned = run(0.0), run(angle)
    assert np.abs(plain[1]).max() > 0.5
    np.testing.assert_allclose(turned[0], plain[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(turned[1], plain[1], rtol=0, atol=1e-9)


def test_momentum_is_what_the_fingers_gave() -> None:
    positions, forces, bench = run(0.0)
    impulse = -T * forces.sum(axis=(0, 1))
    velocity = np.array([bench["box_velocity.x"], bench["box_velocity.y"]])
    np.testing.assert_allclose(MASS * velocity, impulse, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        bench.planar("box_pose")[:2], MASSES @ nodes(bench) / MASS, rtol=0, atol=1e-15
    )
    assert np.ptp(positions[:, 7, 1]) > 1e-3


def test_a_free_lattice_keeps_momentum_and_loses_vibration() -> None:
    _, _, bench = run(0.0, 180)
    for _ in range(20):
        bench.put((0.0, 0.09), (0.0, -0.09))
        bench.step()
    bench.put((0.0, 0.09), (0.0, -0.09))

    def shape() -> float:
        x = nodes(bench)
        return sum(
            (np.linalg.norm(x[j] - x[i]) - SIDE / 2 * np.sqrt(2 if abs(j - i) in {2, 4} else 1))
            ** 2
            for i, j in springs()
        )

    start, vibration = bench.planar("box_velocity"), shape()
    for _ in range(600):
        bench.step()
    np.testing.assert_allclose(bench.planar("box_velocity")[:2], start[:2], rtol=0, atol=1e-13)
    assert bench["box_velocity.theta"] == pytest.approx(start[2], rel=0.05)
    assert shape() < 0.2 * vibration


def test_a_soft_object_at_rest_stays_at_rest() -> None:
    bench = Bench("distributed_workstation", [(0.5, 0.5)], environment=1, peers=0)
    bench.put((0.5, 0.5))
    start = nodes(bench)
    for _ in range(200):
        bench.step()
    np.testing.assert_array_equal(nodes(bench), start)


def test_a_stiff_lattice_is_dented_no_more_than_the_box() -> None:
    """Squeezed alike, the stiffer lattice takes the box's force, the soft one less."""

    def squeeze(**parameters: Any) -> float:
        bench = Bench(
            "distributed_workstation", [(0.0, 0.05), (0.0, -0.05)], [0.0, np.pi], **parameters
        )
        for tick in range(800):
            depth = min(1e-5 * tick, 0.004)
            bench.put((0.0, 0.05 - depth), (0.0, -0.05 + depth))
            bench.step()
        return bench["finger_1.normal_force"]

    rigid = squeeze(peers=0)
    soft = [squeeze(environment=1, peers=0, soft_stiffness=k) for k in (400.0, 1500.0, 4500.0)]
    assert all(a < b for a, b in pairwise(soft))
    assert 0.8 * rigid < soft[-1] < rigid
    assert soft[0] < 0.6 * rigid


def test_copies_are_pulled_together_as_wholes() -> None:
    bench = Bench("distributed_workstation", [(0.5, 0.5)], environment=1, ground_friction=0.0)
    bench.put((0.5, 0.5))
    for name, value in {"source_tick": 0, "box_x": 0.02, "box_theta": 0.3}.items():
        bench[f"peer_1.{name}"] = value
    for _ in range(3000):
        bench.step()
    np.testing.assert_allclose(bench.planar("box_pose"), [0.02, 0.0, 0.3], rtol=0, atol=1e-6)


@pytest.mark.parametrize("inertia", [6.7e-4, 4e-4, 1.2e-3])
def test_a_wrench_moves_it_with_the_stated_mass_and_inertia(inertia: float) -> None:
    """As a whole, without a dent: exactly m and J in the first tick, the box's motion after 20."""
    coupling = {
        "coupling_stiffness": 30.0,
        "coupling_rotational_stiffness": 2.2,
        "ground_friction": 0.0,
        "ground_rotational_friction": 0.0,
        "inertia": inertia,
        "integration": 0,
    }
    soft, rigid = (
        Bench("distributed_workstation", [(0.5, 0.5)], environment=kind, **coupling)
        for kind in (1, 0)
    )
    for bench in (soft, rigid):
        bench.put((0.5, 0.5))
        for name, value in {"source_tick": 0, "box_x": 0.02, "box_theta": 1e-3}.items():
            bench[f"peer_1.{name}"] = value
    acted = soft.planar("coupling_wrench")
    soft.step()
    rigid.step()
    expected = T * acted / [MASS, MASS, inertia]
    np.testing.assert_allclose(soft.planar("box_velocity"), expected, rtol=1e-9, atol=1e-15)
    for _ in range(20):
        soft.step()
        rigid.step()
    moved = rigid.planar("box_pose")
    assert moved[2] > 1e-5
    np.testing.assert_allclose(soft.planar("box_pose"), moved, rtol=2e-3, atol=1e-9)


@pytest.mark.parametrize("inertia", [1.51e-3, 3e-3])
def test_an_inertia_that_no_square_has_is_refused(inertia: float) -> None:
    with pytest.raises(Exception, match="three eighths"):
        Bench("distributed_workstation", [(0.5, 0.5)], environment=1, inertia=inertia)


def test_walls_hold_the_outline() -> None:
    wall = {
        "wall_1.enabled": True,
        "wall_1.point_y": -0.05,
        "wall_1.tangential_damping": 30.0,
    }
    bench = Bench("distributed_workstation", [(0.0, 0.05)], environment=1, peers=0, **wall)
    for tick in range(2500):
        bench.put((0.0, 0.05 - min(1e-5 * tick, 0.006)))
        bench.step()
    pushed = bench["finger_1.normal_force"]
    assert pushed > 0.5
    assert bench["wall_wrench.y"] == pytest.approx(pushed, abs=0.05 * MASS * 9.81)
    assert bench["wall_penetration"] < 3e-4


@pytest.mark.parametrize(
    "name", ["normal_damping", "tangential_damping", "normal_stiffness", "tangential_stiffness"]
)
def test_a_wall_that_shakes_a_corner_is_refused(name: str) -> None:
    """Explicit dampers on 22 g: what the rigid box stands, its corner does not."""
    values = {"wall_2.tangential_damping": 30.0, f"wall_2.{name}": 60.0}
    if "stiffness" in name:
        values[f"wall_2.{name}"] = 5e4
    wall = {"wall_2.enabled": True, **values}
    Bench("distributed_workstation", [(0.5, 0.5)], environment=0, **wall)
    with pytest.raises(Exception, match="wall_2 is too stiff"):
        Bench("distributed_workstation", [(0.5, 0.5)], environment=1, **wall)


def test_an_unstable_lattice_is_refused() -> None:
    with pytest.raises(Exception, match="soft_stiffness"):
        Bench("distributed_workstation", [(0.5, 0.5)], environment=1, soft_stiffness=1e5)
