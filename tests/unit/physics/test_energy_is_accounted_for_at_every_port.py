"""What goes into the world through its ports is stored or dissipated, to 1e-9 J.

A finger strikes the box from above, drags it along a rough ground, slips, and asks for more force
than its device gives. The box does not turn, so that every term has a closed form.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Bench, T

K_N, B_N, K_T, B_T, MASS, HALF, GROUND, MU = 800.0, 3.0, 1200.0, 10.0, 0.4, 0.05, 0.05, 0.6
SLIDE = 3
TICKS = 700


def path(tick: int) -> tuple[float, float]:
    t = tick * T
    return 0.02 * np.sin(14.0 * t), 0.0508 - 0.005 * np.sin(9.0 * t) ** 2


def run(max_force: float, push: int) -> dict[str, np.ndarray]:
    bench = Bench("distributed_workstation", [(0.0, HALF)], peers=0, inertia=1e9)
    bench.instance.set({"finger_1.max_force": max_force, "box_is_pushed_with": push})
    bench.instance.initialise()
    rows: dict[str, list[Any]] = {
        name: [] for name in ("x", "v", "force", "normal", "along", "state", "q", "w", "box", "e")
    }
    for tick in range(TICKS):
        bench.put(path(tick))
        rows["x"].append(bench["finger_1.position"])
        rows["v"].append(bench["finger_1.velocity"])
        rows["force"].append(bench["finger_1.force"])
        rows["normal"].append(bench["finger_1.normal_force"])
        rows["along"].append(bench["finger_1.tangential_force"])
        rows["state"].append(bench["finger_1.contact_state"])
        rows["q"].append(bench.planar("box_pose")[:2])
        rows["w"].append(bench.planar("box_velocity")[:2])
        rows["box"].append(bench.planar("finger_wrench")[:2])
        rows["e"].append(bench["finger_1.observed_energy"])
        bench.step()
    return {name: np.array(values) for name, values in rows.items()} | {
        "saturated": np.array(bench["finger_1.saturated_ticks"])
    }


def spring_energy(r: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Of the normal spring and of the tangential one, J; shape (ticks,) each."""
    depth = HALF - (r["x"][:, 1] - r["q"][:, 1])
    touching = r["state"] > 0
    relative = r["v"] - r["w"]
    stretch = -(r["along"] + B_T * -relative[:, 0]) / K_T  # t is (-1, 0)
    stuck = touching & (r["state"] != SLIDE)
    return (
        np.where(touching, 0.5 * K_N * depth**2, 0.0),
        np.where(stuck, 0.5 * K_T * stretch**2, 0.0),
    )


def follow_the_laws_of_friction(r: dict[str, np.ndarray]) -> None:
    """Coulomb's where it slides, at most that where it sticks, none where nothing touches.

    So that what is taken as friction's below is no mere remainder.
    """
    state, normal, along = r["state"], r["normal"], r["along"]
    sliding = state == SLIDE
    np.testing.assert_allclose(np.abs(along[sliding]), MU * normal[sliding], atol=1e-12)
    stuck = (state > 0) & ~sliding
    assert stuck.any()
    assert np.all(np.abs(along[stuck]) <= MU * normal[stuck] + 1e-12)
    assert np.all(along[state == 0] == 0.0)


@pytest.mark.parametrize("push", [0, 1])
@pytest.mark.parametrize("max_force", [1e6, 0.4])
def test_the_audit_closes(max_force: float, push: int) -> None:
    r = run(max_force, push)
    assert (r["state"] == SLIDE).any()
    assert (r["state"] == 0).any()
    assert (r["saturated"] > 0) == (max_force < 10)
    follow_the_laws_of_friction(r)
    moved, carried = np.diff(r["x"], axis=0), np.diff(r["q"], axis=0)
    wanted = np.column_stack([-r["along"], r["normal"]])[:-1]
    rendered, onto = r["force"][:-1], r["box"][:-1]
    put_in = r["e"][-1]

    # What the device does not give, and what the box is pushed with all the same.
    saturation = np.sum((wanted - rendered) * moved)
    reaction = np.sum((wanted + onto) * carried)

    # The box: Euler's rule with the ground's friction as an impulse.
    before, after = r["w"][:-1], r["w"][1:]
    free = before + T / MASS * onto
    kinetic = 0.5 * MASS * (after[-1] @ after[-1])
    ground = 0.5 * MASS * np.sum(free**2 - after**2)
    euler = np.sum(MASS * (free - before) * after - 0.5 * MASS * (free**2 - before**2))
    np.testing.assert_allclose(np.sum(onto * carried), kinetic + ground + euler, atol=1e-12)
    speed = np.hypot(*free.T)
    kept = np.maximum(0.0, 1.0 - GROUND * 9.81 * T / np.maximum(speed, 1e-300))
    np.testing.assert_allclose(after, free * kept[:, None], rtol=0, atol=1e-14)

    # The coupler: springs, dampers, and what is gained because a force is held while depth changes.
    normal_energy, along_energy = spring_energy(r)
    depth = HALF - (r["x"][:, 1] - r["q"][:, 1])
    touching, push_law = r["state"] > 0, K_N * depth - B_N * (r["v"] - r["w"])[:, 1]
    if push == 0 or max_force > 10:
        expected = np.where(touching, np.maximum(push_law, 0.0), 0.0)
        np.testing.assert_allclose(r["normal"], expected, atol=1e-9)
    sinking = np.diff(depth)
    smooth = touching[:-1] & touching[1:] & (push_law[:-1] > 0)
    damper = np.sum((-B_N * (r["v"] - r["w"])[:-1, 1] * sinking)[smooth])
    hold = np.sum((-0.5 * K_N * sinking**2)[smooth])
    gap = r["normal"][:-1] * sinking - np.diff(normal_energy)
    edges = np.sum(gap[~smooth])
    cut = np.sum((r["normal"][:-1] - push_law[:-1])[smooth] * sinking[smooth])
    slipping = np.diff(-(r["x"][:, 0] - r["q"][:, 0]))
    friction = np.sum(-r["along"][:-1] * slipping) - along_energy[-1]
    assert friction > 0.0

    stored = kinetic + normal_energy[-1] + along_energy[-1]
    dissipated = ground + euler + damper + hold + edges + cut + friction
    assert abs(put_in - (stored + dissipated + saturation - reaction)) < 1e-9


def test_a_held_spring_gives_out_what_the_hold_gains() -> None:
    """Exactly: E = k x²/2 - Σ k Δx²/2, negative where today's force times the step is positive."""
    bench = Bench("remote_client", [(0.0, 0.0)], local_damping=0.0)
    x, seen = [], []
    for tick in range(1000):
        x.append(0.003 * np.sin(0.4 * tick))
        bench.put((x[-1], 0.0))
        bench["down.finger_1_force"] = (-800.0 * x[-1], 0.0)
        seen.append(bench["finger_1.observed_energy"])
        bench.step()
    place = np.array(x)
    gained = np.concatenate([[0.0], np.cumsum(0.5 * 800.0 * np.diff(place) ** 2)])
    exact = 0.5 * 800.0 * (place**2 - place[0] ** 2) - gained
    np.testing.assert_allclose(seen, exact, rtol=0, atol=1e-12)
    assert exact[-1] < -0.1
    todays = np.cumsum(800.0 * place[1:] * np.diff(place))[-1]
    assert todays > 0.1


def test_network_ports_count_what_crosses_them() -> None:
    """A peer's finger and its copy of the box, each with the force that was held."""
    bench = Bench("distributed_workstation", [(0.0, 0.2)], peers=1)
    bench["peer_valid[1]"], bench["peer_weight[1]"] = 1, 1.0
    finger, box, place, pose = 0.0, 0.0, None, None
    force = pull = None
    for tick in range(300):
        bench.put((0.0, 0.2))
        bench["peer_1.source_tick"], bench["peer_1.status"] = tick, 32 + 11
        here = np.array([0.0, 0.049 - 0.002 * np.sin(0.05 * tick)])
        copy = np.array([0.001 * np.sin(0.03 * tick), 0.0, 0.01 * np.sin(0.02 * tick)])
        bench["peer_1.finger_1_position"] = here
        for name, value in zip(("box_x", "box_y", "box_theta"), copy, strict=True):
            bench[f"peer_1.{name}"] = value
        if force is not None:
            finger -= force @ (here - place)
            box -= pull @ (copy - pose)
        assert bench["peer_contact_1.finger_1_energy"] == pytest.approx(finger, abs=1e-12)
        assert bench["peer_contact_1.coupling_energy"] == pytest.approx(box, abs=1e-12)
        own, wrench = bench.planar("box_pose"), bench.planar("coupling_wrench")
        touch = np.zeros(2)
        if bench["peer_contact_1.finger_1_contact_state"] > 0:
            normal = bench["peer_contact_1.finger_1_normal_force"]
            turn = np.array([-np.sin(own[2]), np.cos(own[2])])
            along = -(wrench[:2] - copy_pull(own, copy, bench)) - normal * turn
            touch = normal * turn + along
        force, pull = touch, np.append(-copy_pull(own, copy, bench), -spin_pull(own, copy, bench))
        place, pose = here, copy
        bench.step()
    assert abs(finger) > 1e-5
    assert abs(box) > 1e-6


def copy_pull(own: np.ndarray, copy: np.ndarray, bench: Bench) -> np.ndarray:
    return 77.5 * (copy - own)[:2] - 10.0 * bench.planar("box_velocity")[:2]


def spin_pull(own: np.ndarray, copy: np.ndarray, bench: Bench) -> float:
    return float(2.2 * (copy - own)[2] - 0.05 * bench.planar("box_velocity")[2])


def test_a_device_behind_an_amplifier_reports_its_own_work() -> None:
    bench = Bench("remote_client", [(0.0, 0.0)], **{"finger_1.device_reports_work": 1})
    for tick in range(50):
        bench.put((0.001 * tick, 0.0))
        bench["finger_1.device_work"] = 0.25 * tick
        assert bench["finger_1.observed_energy"] == -0.25 * tick
        bench.step()


def struck(push: int) -> tuple[float, int]:
    """Energy after an impact over that before, and how many ticks were saturated.

    100 g strike the box at 0.3 m/s; the device gives 0.4 N of the 3 N that the coupler asks for.
    """
    bench = Bench(
        "distributed_workstation", [(0.0, 0.06)], peers=0, inertia=1e9, ground_friction=0.0
    )
    bench.instance.set({"finger_1.max_force": 0.4, "box_is_pushed_with": push})
    bench.instance.initialise()
    mass, y, v = 0.1, 0.06, -0.3
    for _ in range(400):
        bench.put((0.0, y))
        force = float(bench["finger_1.force"][1])
        bench.step()
        y, v = y + T * v + 0.5 * T * T * force / mass, v + T * force / mass
    speed = bench.planar("box_velocity")[:2]
    depth = max(0.0, HALF - (y - bench.planar("box_pose")[1]))
    after = 0.5 * mass * v * v + 0.5 * MASS * speed @ speed + 0.5 * K_N * depth**2
    return float(after / (0.5 * mass * 0.3**2)), int(bench["finger_1.saturated_ticks"])


def test_a_limited_device_gains_no_energy_where_the_box_gets_what_the_hand_does() -> None:
    gained, saturated = struck(0)
    assert gained > 1.2
    assert saturated > 10
    assert struck(1)[0] < 1.01
