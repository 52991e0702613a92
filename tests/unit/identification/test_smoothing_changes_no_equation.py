"""A derivative is exact where it should be, and a held torque is late by what it is late."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.identification.kernels import Kernel

TICK = 1 / 1024
KERNEL = Kernel(width=8e-3, tick=TICK)


def samples(function, rows=2000):
    at = np.arange(rows) * TICK
    return at[KERNEL.reach : -KERNEL.reach], np.stack([function(at)] * 2, axis=1)


@pytest.mark.parametrize("derivative", range(3))
def test_polynomials_pass_unchanged(derivative):
    polynomial = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.5])
    inner, given = samples(polynomial)
    expected = polynomial.deriv(derivative)(inner) if derivative else polynomial(inner)
    assert KERNEL.smooth(given, derivative)[:, 0] == pytest.approx(expected, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("delay", [0.0, 0.3 * TICK, 1.7 * TICK])
@pytest.mark.parametrize("frequency", [2.0, 8.0, 15.0])
def test_a_held_torque_is_half_a_tick_and_its_delay_late(frequency, delay):
    turn = 2 * np.pi * frequency
    inner, given = samples(lambda at: np.sin(turn * at))
    half = TICK / 2
    x = (KERNEL.width * turn) ** 2 / 2
    size = np.exp(-x) * (1 + x + x**2 / 2) * np.sinc(frequency * TICK)
    found = KERNEL.smooth_held(given, delay)[:, 0]
    assert found == pytest.approx(size * np.sin(turn * (inner - half - delay)), abs=2e-6)


def test_the_pass_band_is_flat():
    x = (KERNEL.width * 2 * np.pi * 15.0) ** 2 / 2
    assert np.exp(-x) * (1 + x + x**2 / 2) == pytest.approx(1.0, abs=0.004)
