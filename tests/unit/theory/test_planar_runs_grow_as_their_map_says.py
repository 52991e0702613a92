"""Pushed along a mode, the planar run grows and swings as the mode does, period by period."""

from __future__ import annotations

import cmath

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.monodromy.run_map import RunMap
from cosim.scenario.load import read
from tests.support.theory.continued import pushed

SERVER = "components.server.parameters"
BOTH = "components.vr_{}.parameters.{}={}"
PERIODS = 24


def station(name: str, value: object) -> list[str]:
    return [BOTH.format(which, name, value) for which in "ab"]


RUNS: list[tuple[str, list[str]]] = [
    ("two_users_box", []),
    ("two_users_box_centralized", []),
]
SLOW: list[tuple[str, list[str]]] = [
    *(("two_users_box", [f"channels.lan.round_trip_delay={n}"]) for n in (0, 2, 3)),
    ("two_users_box", station("predictor", "linear")),
    ("two_users_box", station("environment", "mass_spring")),
    ("two_users_box", station("coupling_stiffness", 300)),
    ("two_users_box", station("local_normal_stiffness", 1500)),
    ("two_users_box", station("remote_normal_damping", 8)),
    ("two_users_box", station("mass", 0.8)),
    ("two_users_box", ["rates.network=64 Hz"]),
    ("two_users_box", ["channels.lan.round_trip_delay='7 ticks'"]),
    ("two_users_box", [f"components.finger_{f}.parameters.substeps=2" for f in ("a1", "a2")]),
    ("two_users_box", [f"components.finger_{f}.parameters.finger_mass=0.12" for f in ("a1", "b1")]),
    *(
        ("two_users_box_centralized", [f"{SERVER}.remote_normal_stiffness={k}", *more])
        for k, more in (
            (170, []),
            (400, []),
            (170, ["channels.lan.round_trip_delay=2"]),
            (170, ["components.finger_b1.parameters.computation_delay_ticks=2"]),
            (300, ["channels.lan.round_trip_delay=0"]),
        )
    ),
]


def fitted(run: RunMap, shape: np.ndarray, *, swings: bool) -> complex:
    """The eigenvalue over one hyperperiod that a motion along a shape shows.

    The run goes on by itself from the push; runs with the push and with its opposite are compared,
    so that what the operating point still drifts (1e-11) does not count.
    """
    rows = pushed(run, shape, PERIODS)[:, np.abs(shape) > 0.01 * np.abs(shape).max()]
    if not swings:
        return complex((rows[1:] * rows[:-1]).sum() / (rows[:-1] ** 2).sum())
    first, second, third = (rows[n : PERIODS - 2 + n].reshape(-1) for n in range(3))
    a, b = np.linalg.lstsq(np.column_stack([second, first]), third, rcond=None)[0]
    return complex(np.roots([1.0, -a, -b])[0])


def check(name: str, sets: list[str]) -> None:
    with ask(read(name, (), sets)) as asked:
        point = asked.point()
        mode = point.spectrum(with_modes=True).modes[0]
        value = cmath.exp(complex(mode.growth, mode.frequency) * float(point.seconds))
        shape = np.real(mode.shape * np.exp(-1j * np.angle(mode.shape[np.argmax(abs(mode.shape))])))
        swings = mode.frequency > 0.0
        found = fitted(point.run, 1e-6 * shape / np.abs(shape).max(), swings=swings)
        assert abs(found) == pytest.approx(abs(value), rel=1e-5)
        assert abs(cmath.phase(found)) == pytest.approx(abs(cmath.phase(value)), rel=1e-5)


@pytest.mark.parametrize("number", range(len(RUNS)))
def test_growth_and_frequency_of_the_grasp(number: int) -> None:
    check(*RUNS[number])


@pytest.mark.one_in(6)
@pytest.mark.parametrize("number", range(len(SLOW)))
def test_growth_and_frequency_of_other_grasps(number: int) -> None:
    check(*SLOW[number])
