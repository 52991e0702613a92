"""Nothing depends on where north is, which hand is left, or who is called first."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.physics.planar_oracle import Array, Bench

FINGERS = [(0.012, 0.049), (-0.008, -0.049)]
PEER_FINGERS = [(0.049, 0.004), (-0.048, 0.013)]
WALL_POINT, WALL_NORMAL = np.array([0.0, 0.053]), np.array([0.05, -1.0])
PEER_BOX = (np.array([0.004, -0.006]), 0.15)


class Motion:
    """A rigid motion of the plane, mirrored first if ``mirror``."""

    def __init__(self, angle: float, shift: Array, *, mirror: bool) -> None:
        c, s = np.cos(angle), np.sin(angle)
        self.angle, self.shift = angle, np.asarray(shift)
        self.hand = -1.0 if mirror else 1.0
        self.turn = np.array([[c, -s], [s, c]]) @ np.diag([self.hand, 1.0])

    def point(self, p: Any) -> Array:
        return self.turn @ np.asarray(p) + self.shift

    def pose(self, p: Array, angle: float) -> Array:
        return np.array([*self.point(p), self.hand * angle + self.angle])

    def vector(self, wrench: Array) -> Array:
        return np.array([*(self.turn @ wrench[:2]), self.hand * wrench[2]])


def paths(tick: int) -> tuple[list[Array], list[Array]]:
    """Own and peer finger positions (m): squeeze, shake and turn the box."""
    press = np.array([0.0, 1.0]) * min(tick * 5e-5, 0.005)
    sway = 0.004 * np.array([np.sin(0.05 * tick), 0.3 * np.sin(0.08 * tick)])
    own = [FINGERS[0] - press + sway, FINGERS[1] + press + 0.8 * sway]
    side = np.array([1.0, 0.0]) * min(tick * 3e-5, 0.003)
    peer = [PEER_FINGERS[0] - side + 0.5 * sway, PEER_FINGERS[1] + side]
    return own, peer


def run(motion: Motion, *, ticks: int = 160, swap: bool = False) -> tuple[Array, Array, Array]:
    """Box poses, velocities and finger forces in the moved world."""
    order = [1, 0] if swap else [0, 1]
    pose = motion.pose(np.zeros(2), 0.02)
    point, normal = motion.point(WALL_POINT), motion.turn @ WALL_NORMAL
    values = {
        **dict(zip((f"initial_box_pose.{a}" for a in ("x", "y", "theta")), pose, strict=True)),
        "wall_1.enabled": True,
        "wall_1.point_x": point[0],
        "wall_1.point_y": point[1],
        "wall_1.normal_x": normal[0],
        "wall_1.normal_y": normal[1],
    }
    centres = [tuple(motion.point(FINGERS[i])) for i in order]
    bench = Bench("distributed_workstation", centres, **values)
    box = motion.pose(*PEER_BOX)
    bench["peer_1.box_x"], bench["peer_1.box_y"], bench["peer_1.box_theta"] = box
    bench["peer_1.source_tick"], bench["peer_1.status"] = 0, 11 + 32 + 64
    poses, velocities, forces = [], [], []
    for tick in range(ticks):
        own, peer = paths(tick)
        bench.put(*(motion.point(own[i]) for i in order))
        for number, i in enumerate(order, start=1):
            bench[f"peer_1.finger_{number}_position"] = motion.point(peer[i])
        poses.append(bench.planar("box_pose"))
        velocities.append(bench.planar("box_velocity"))
        forces.append([bench[f"finger_{number}.force"] for number in (1, 2)])
        bench.step()
    ordered = np.array(forces)[:, order]
    return np.array(poses), np.array(velocities), ordered


@pytest.fixture(scope="module")
def plain() -> tuple[Array, Array, Array]:
    return run(Motion(0.0, np.zeros(2), mirror=False))


@settings(deadline=None, max_examples=10)
@given(
    angle=st.floats(-3, 3),
    shift=st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5)),
    mirror=st.booleans(),
)
def test_turned_and_mirrored_worlds_do_the_same(
    plain: tuple[Array, Array, Array], angle: float, shift: tuple[float, float], mirror: bool
) -> None:
    motion = Motion(angle, np.array(shift), mirror=mirror)
    poses, velocities, forces = run(motion)
    expected = np.array([motion.pose(p[:2], p[2]) for p in plain[0]])
    np.testing.assert_allclose(poses, expected, rtol=0, atol=1e-9)
    speeds = np.array([motion.vector(v) for v in plain[1]])
    np.testing.assert_allclose(velocities, speeds, rtol=0, atol=1e-9)
    np.testing.assert_allclose(forces, plain[2] @ motion.turn.T, rtol=0, atol=1e-9)
    assert np.abs(plain[2]).max() > 1.0


def test_which_finger_is_called_first_does_not_matter(plain: tuple[Array, Array, Array]) -> None:
    swapped = run(Motion(0.0, np.zeros(2), mirror=False), swap=True)
    for one, other in zip(plain, swapped, strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-9)


def test_which_peer_is_called_first_does_not_matter() -> None:
    def final(order: list[int]) -> Array:
        bench = Bench("distributed_workstation", [(0.0, 0.049)], peers=3)
        bench.put((0.0, 0.047))
        for place, peer in enumerate(order, start=1):
            bench[f"peer_{place}.source_tick"], bench[f"peer_{place}.status"] = 0, 11 + 32
            bench[f"peer_{place}.box_x"] = 0.003 * peer
            bench[f"peer_{place}.box_omega"] = 0.1 * peer
            bench[f"peer_{place}.finger_1_position"] = (0.049 - 0.001 * peer, 0.01 * peer)
            bench[f"peer_weight[{place}]"] = 1 - 0.2 * peer
        for _ in range(100):
            bench.step()
        return bench.planar("box_pose")

    first = final([1, 2, 3])
    assert abs(first[0]) > 1e-5
    for order in ([2, 1, 3], [3, 1, 2]):
        np.testing.assert_allclose(final(order), first, rtol=0, atol=1e-9)


def test_which_user_is_called_first_does_not_matter() -> None:
    """Two coupled copies, the users exchanged: each does what the other did, to the bit."""

    def both(order: list[int]) -> list[Array]:
        places = [(0.0, 0.049), (0.01, -0.049)]
        users = [Bench("distributed_workstation", [places[i]]) for i in order]
        held: list[dict[str, Any]] = [{}, {}]
        out = []
        for tick in range(200):
            own, _ = paths(tick)
            for bench, i in zip(users, order, strict=True):
                bench.put(own[i])
            if tick % 8 == 0:
                held = [packet(bench) for bench in users]
            for bench, values in zip(users, reversed(held), strict=True):
                for name, value in values.items():
                    bench[f"peer_1.{name}"] = value
            for bench in users:
                bench.step()
            out.append([bench.planar("box_pose") for bench in users])
        return [np.array(out)[:, order.index(i)] for i in (0, 1)]

    for one, other in zip(both([0, 1]), both([1, 0]), strict=True):
        np.testing.assert_array_equal(one, other)
        assert np.ptp(one) > 1e-4


def packet(bench: Bench) -> dict[str, Any]:
    """What the workstation would send."""
    members = next(t for t in bench.instance.model.terminals if t.name == "shared").members
    return {name: bench[path] for name, path in members.items()}
