"""A design for a random network stands each of its corners in the simulation, compensation in."""

from __future__ import annotations

import time
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cosim.analysis.answers.confirmed import confirmed
from cosim.theory.chance.network import Network
from cosim.theory.design.search import design
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters

MARGIN = 0.25


def random_case(number: int) -> tuple[Parameters, Network]:
    generator = np.random.default_rng(number)
    architecture: Architecture = "distributed" if number % 2 else "centralized"
    given = {"m_h": float(generator.uniform(0.05, 0.2)), "m_o": float(generator.uniform(0.2, 0.8))}
    period = Fraction(1, int(generator.choice([64, 128, 256])))
    delay = float(generator.uniform(0.0, 2.5)) * float(period)
    loss = float(generator.choice([0.0, generator.uniform(0.0, 0.1)]))
    network = Network(period, delay, 0.0, loss)
    return Parameters(architecture, given, CHAPTER_5[architecture]), network


def check(number: int) -> None:
    parameters, network = random_case(number)
    found = design(parameters, network, Fraction(1, 1024), MARGIN)
    seen = confirmed(parameters, network, found, MARGIN)
    assert seen.keys() == found.corners.keys()
    for name, radius in seen.items():
        assert radius < 1.0, (number, name)
        assert radius == pytest.approx(found.corners[name], abs=1e-6), (number, name)


@pytest.mark.parametrize("number", range(4))
def test_corners_hold_in_the_simulation(number: int) -> None:
    check(number)


@pytest.mark.one_in(8)
@pytest.mark.parametrize("number", range(4, 50))
def test_more_corners_hold_in_the_simulation(number: int) -> None:
    check(number)


def test_twice_the_stiffness_breaks_the_promise() -> None:
    """The margin is used: what is designed is not merely soft."""
    parameters, network = random_case(1)
    found = design(parameters, network, Fraction(1, 1024), MARGIN)
    stiffer = {name: 2 * value for name, value in found.gains.items() if name[0] == "k"}
    broken = confirmed(parameters, network, replace(found, gains=found.gains | stiffer), MARGIN)
    assert max(broken.values()) > 1.0


def test_a_design_takes_less_than_three_tenths_of_a_second() -> None:
    parameters, network = random_case(3)
    times = []
    for _ in range(3):
        began = time.process_time()
        design(parameters, network, Fraction(1, 1024), MARGIN)
        times.append(time.process_time() - began)
    assert min(times) < 0.3


@pytest.mark.slow
def test_late_packets_hold_in_the_simulation() -> None:
    """Jitter too: each packet draws its delay in the run's own maps."""
    parameters, steady = random_case(1)
    network = replace(steady, delay=0.5 * float(steady.period), jitter=0.002, loss=0.02)
    found = design(parameters, network, Fraction(1, 1024), MARGIN)
    seen = confirmed(parameters, network, found, MARGIN)
    assert seen.keys() == found.corners.keys()
    assert sum(name.startswith("loss and jitter") for name in seen) == 2
    for name, radius in seen.items():
        assert radius < 1.0, name
        assert radius == pytest.approx(found.corners[name], abs=1e-6), name
