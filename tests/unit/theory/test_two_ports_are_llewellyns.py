"""Absolute stability, indices of transparency and Z-width agree with what is known of them."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.theory.models.parameters import TABLE_6_1, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.robust.transparency import PassiveHand, lawrence, yokokohji
from cosim.theory.robust.two_port import TwoPort, default_frequencies, two_port
from cosim.theory.robust.z_width import RenderedWall, as_built, by_eigenvalues, by_rule

FREQUENCIES = np.geomspace(0.1, 100.0, 200)


def through(transfer: complex, damping: float = 1.0) -> TwoPort:
    """Two dampers (N·s/m) with something between them that passes in one direction as given."""
    one = np.full(FREQUENCIES.shape, 1.0 / damping, dtype=np.complex128)
    y = np.stack([np.stack([one, one * 0.5], -1), np.stack([one * transfer, one], -1)], axis=-2)
    return TwoPort(FREQUENCIES, y, stable=True)


def test_a_reciprocal_passive_network_is_absolutely_stable():
    assert through(0.5).absolutely_stable()


def test_a_gain_of_eight_is_too_much():
    # 2·1·1 ≥ |0.5 t| + 0.5 t only up to t = 2.
    assert through(1.99).absolutely_stable()
    assert not through(2.01).absolutely_stable()
    assert not through(8.0).absolutely_stable()


def test_the_damping_that_is_asked_for_is_what_it_takes():
    port = through(8.0)
    needed = port.damping_for_absolute_stability()

    def damped(b: float) -> bool:
        impedance = port.impedance + b * np.eye(2)
        return TwoPort(FREQUENCIES, np.linalg.inv(impedance), stable=True).absolutely_stable()

    assert damped(1.001 * needed)
    assert not damped(0.99 * needed)


def loop(architecture: str, samples: int) -> TwoPort:
    model = Parameters(architecture, {}, TABLE_6_1[architecture]).model()
    timing = Timing(delay=PathDelay.round_trip(samples))
    return two_port(model, timing, default_frequencies(timing, 120))


@pytest.mark.parametrize("samples", [0, 1, 2])
def test_the_distributed_loop_of_table_6_1_is_absolutely_stable(samples):
    assert loop("distributed", samples).absolutely_stable()


def test_a_delayed_force_makes_the_remote_users_port_active():
    assert loop("centralized", 0).absolutely_stable()
    port = loop("centralized", 1)
    assert port.stable
    assert not port.absolutely_stable()
    # Re z₂₂ at half the network rate.
    assert port.damping_for_absolute_stability() == pytest.approx(9.0, abs=0.1)


def test_free_is_the_inverse_of_the_own_admittance_and_held_the_own_impedance():
    port = loop("distributed", 1)
    found = lawrence(port, PassiveHand(0.0, 8.0, 300.0))
    assert found.free == pytest.approx(1 / port.admittance[:, 0, 0], rel=1e-9)
    assert found.held == pytest.approx(port.impedance[:, 0, 0], rel=1e-9)
    nobody = lawrence(port, PassiveHand())
    assert nobody.terminated == pytest.approx(nobody.free, rel=1e-9)
    rock = lawrence(port, PassiveHand(0.0, 1e9, 0.0))
    assert rock.terminated == pytest.approx(rock.held, rel=1e-3)


def test_hands_on_one_rigid_mass_are_alike_and_a_delay_parts_them():
    mass = 0.6 * 1j * FREQUENCIES
    y = np.broadcast_to((1 / mass)[:, None, None], (FREQUENCIES.size, 2, 2))
    rigid = TwoPort(FREQUENCIES, np.array(y), stable=True)
    hand = PassiveHand(0.0, 8.0, 300.0)
    assert yokokohji(rigid, hand, hand, 100.0, 0.01).position == pytest.approx(0.0, abs=1e-12)
    softer = yokokohji(loop("centralized", 1), hand, hand, 100.0, 0.01)
    stiffer = yokokohji(loop("distributed", 1), hand, hand, 100.0, 0.01)
    assert softer.position > stiffer.position > 0.0


def test_the_rule_of_z_width_is_exact_without_delay_and_too_high_with_one():
    period = 1 / 1024
    assert by_rule(RenderedWall(0.08, 0.0, period), 10.0) == pytest.approx(20480.0)
    assert by_eigenvalues(RenderedWall(0.08, 0.0, period), 10.0) == pytest.approx(20480.0, rel=1e-9)
    assert by_rule(RenderedWall(0.08, 0.0, period, 1), 10.0) == pytest.approx(6826.7, abs=0.1)
    # A hand of 0.1 kg on an object of 0.4 kg: their reduced mass is 0.08 kg.
    assert by_eigenvalues(RenderedWall(0.08, 0.0, period, 1), 10.0) == pytest.approx(
        6434.7, abs=0.1
    )


def test_what_is_built_without_counts_or_windows_is_what_eigenvalues_say():
    device = RenderedWall(0.1, 0.1, 1 / 1024)
    damping = np.array([5.0, 10.0])
    levels = np.geomspace(0.02, 2.0, 24)
    for one, built in zip(damping, as_built(device, damping), strict=True):
        exact = by_eigenvalues(device, float(one))
        assert built <= exact < built * levels[1] / levels[0]


def test_the_velocitys_window_costs_stiffness():
    damping = np.array([15.0])
    true, windowed = (
        as_built(RenderedWall(0.1, 0.1, 1 / 1024, 0, count, window), damping)[0]
        for count, window in ((0.0, 0), (2e-5, 16))
    )
    assert windowed < 0.7 * true
