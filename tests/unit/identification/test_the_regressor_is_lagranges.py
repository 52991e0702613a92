"""The identification's own equations are those of Lagrange, differentiated by finite differences.

Only places enter here: energies come from differences of places, torques from differences of
energies. And the simulated pantograph, derived elsewhere, gives the same inertia.
"""

from __future__ import annotations

import numpy as np
import pytest

from cosim.identification.five_bar import FiveBar
from cosim.identification.nominal import Nominal
from cosim.identification.regressor import INERTIAS, inertia_matrix, torques
from hil.emulation.plant import Hand, SimulatedPantograph
from tests.support.identification.known import HAPLY, HOME, TICK

QUANSER = FiveBar(proximal=0.100, distal=0.165, base=0.085)
EXACT = 2e-5


def places(bar: FiveBar, angle: np.ndarray) -> list[np.ndarray]:
    elbows = [
        np.array([axis, 0.0]) + bar.proximal * np.array([np.cos(turned), np.sin(turned)])
        for axis, turned in zip((0.0, bar.base), angle, strict=True)
    ]
    # Where both distal links end: the intersection of two circles, above the line of the elbows.
    middle, across = (elbows[0] + elbows[1]) / 2, elbows[1] - elbows[0]
    height = np.sqrt(bar.distal**2 - across @ across / 4) / np.hypot(*across)
    return [middle + height * np.array([-across[1], across[0]]), *elbows]


def energy(bar: FiveBar, which: int, angle: np.ndarray, rate: np.ndarray) -> float:
    step = 1e-6
    ends = [places(bar, angle + side * step * rate) for side in (1, -1)]
    tip, one, two = ((a - b) / (2 * step) for a, b in zip(*ends, strict=True))
    return [
        rate[0] ** 2 / 2,
        rate[1] ** 2 / 2,
        tip @ tip / 2,
        one @ tip,
        two @ tip,
    ][which]


@pytest.mark.parametrize("which", range(len(INERTIAS)), ids=[each.name for each in INERTIAS])
@pytest.mark.parametrize("bar", [HAPLY, QUANSER], ids=["haply", "quanser"])
def test_each_column_is_lagranges_equation(bar, which):
    middle = bar.angles(np.array([[bar.base / 2, 0.62 * (bar.proximal + bar.distal)]]))[0]

    def path(time):
        return middle + np.array([0.3 * np.sin(3 * time), 0.25 * np.sin(4 * time + 1)])

    def momentum(time):
        rate = (path(time + 1e-5) - path(time - 1e-5)) / 2e-5
        return np.array(
            [
                (energy(bar, which, path(time), rate + 0.01 * turn)
                 - energy(bar, which, path(time), rate - 0.01 * turn)) / 0.02
                for turn in np.eye(2)
            ]
        )  # fmt: skip

    time = 0.4
    rate = np.array([0.9 * np.cos(3 * time), np.cos(4 * time + 1)])
    gain = np.array([-2.7 * np.sin(3 * time), -4 * np.sin(4 * time + 1)])
    pull = [
        (energy(bar, which, path(time) + 1e-4 * turn, rate)
         - energy(bar, which, path(time) - 1e-4 * turn, rate)) / 2e-4
        for turn in np.eye(2)
    ]  # fmt: skip
    expected = (momentum(time + 1e-3) - momentum(time - 1e-3)) / 2e-3 - np.array(pull)
    found = torques(bar, path(time)[None], rate[None], gain[None])[0, :, which]
    assert found == pytest.approx(expected, abs=EXACT * np.abs(expected).max())


def test_the_simulated_pantograph_starts_as_the_inertia_at_home_says():
    parameters = {
        "device": 1,
        "initial_tip_position": (0.019, 0.1),
        "finger_mass": 0.05,
        "coulomb_friction": 0.0,
        "dac_bits": 0,
        "encoder_counts": 0,
    }
    model = SimulatedPantograph(parameters, hand=Hand(0.0, 0.0))
    torque = np.array([0.02, -0.03])
    for _ in range(2):
        model.step((torque[0], torque[1]))
    turned = np.array(model.angle()) - HOME
    model.close()
    inertia = inertia_matrix(HAPLY, HOME) @ Nominal.of("haply").values(HAPLY, 0.05)[:5]
    assert turned == pytest.approx(np.linalg.solve(inertia, torque) * (2 * TICK) ** 2 / 2, rel=2e-3)
