"""The passivity controller never lets more energy out than was put in, and else does nothing."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.physics.planar_oracle import Array, Bench, T


def active_wall(**parameters: float) -> tuple[Array, Array]:
    """A finger on a stiff, undamped, held spring: velocity and force (x) by tick.

    The force lags by eight ticks, as a force that comes over a network does, and so pumps energy.
    """
    bench = Bench("remote_client", [(0.0, 0.0)], local_damping=0.0, **parameters)
    x, v, held, out = 0.004, 0.0, 0.0, []
    for tick in range(500):
        if tick % 8 == 0:
            held = -800.0 * x
        bench.put((x, 0.0))
        bench["down.finger_1_force"] = (held, 0.0)
        force = bench["finger_1.force"][0]
        out.append([bench["finger_1.velocity"][0], force, bench["finger_1.observed_energy"], x])
        bench.step()
        x, v = x + T * v + 0.5 * T * T * force / 0.1, v + T * force / 0.1
        x = float(np.clip(x, -0.04, 0.04))
    return np.array(out).T


def test_the_held_spring_is_active_and_the_controller_tames_it() -> None:
    free, tamed = active_wall(), active_wall(passivity=1, passivity_damping_limit=100.0)
    assert np.abs(free[3][-100:]).max() > 3 * 0.004
    assert free[2].min() < -0.01
    assert np.abs(tamed[3][-100:]).max() < 0.004


def test_the_observer_counts_what_was_held_while_the_finger_moved() -> None:
    _, force, observed, x = active_wall()
    exact = np.concatenate([[0.0], -np.cumsum(force[:-1] * np.diff(x))])
    np.testing.assert_allclose(observed, exact, rtol=0, atol=1e-12)


def test_hardly_any_energy_comes_out_below_the_limit_without_overshoot() -> None:
    """0.34 m/T for 100 g: the controller looks a tick ahead, and what it misses is a tick's."""
    free = active_wall()[2].min()
    controlled = active_wall(passivity=1, passivity_damping_limit=0.34 * 0.1 / T)[2].min()
    assert -1e-3 < controlled < 0.0
    assert free < -1.0


def test_damping_is_bounded() -> None:
    _, force, _, x = active_wall(passivity=1, passivity_damping_limit=5.0)
    held = np.repeat(-800.0 * x[::8], 8)[: len(x)]
    added = np.abs(force - held)
    speed = np.abs(np.diff(x, prepend=x[0])) / T
    assert np.all(added <= 5.0 * speed + 1e-9)
    assert added.max() > 0.1


def test_a_passive_force_is_not_touched() -> None:
    """Pure damping only takes energy."""
    results = []
    for passivity in (0, 1):
        bench = Bench("remote_client", [(0.0, 0.0)], local_damping=3.0, passivity=passivity)
        bench["peer_weight[1]"] = 0.0
        forces = []
        for tick in range(100):
            bench.put((0.01 * np.sin(0.1 * tick), 0.0))
            forces.append(bench["finger_1.force"])
            bench.step()
        results.append(np.array(forces))
    np.testing.assert_array_equal(*results)
    assert np.abs(results[0]).max() > 0.1


@pytest.mark.parametrize("reserve", [1e-4, 1e-3])
def test_no_more_than_the_reserve_is_kept(reserve: float) -> None:
    bench = Bench("remote_client", [(0.0, 0.0)], passivity=1, passivity_reserve=reserve)
    x = 0.0
    for _ in range(100):
        x += 0.05 * T
        bench.put((x, 0.0))
        bench["down.finger_1_force"] = (-1.0, 0.0)
        bench.step()
    assert bench["finger_1.observed_energy"] == reserve
