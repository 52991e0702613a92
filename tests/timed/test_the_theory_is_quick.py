"""What a user waits for an answer of the theory, in processor time of one core.

The aims are 10 s for the margins of a planar scenario and 0.3 s for a design; half as much again is
allowed, as a busy machine takes that for the same work.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from fractions import Fraction

import pytest

from cosim.theory.chance.network import Network
from cosim.theory.design.search import design
from cosim.theory.models.parameters import CHAPTER_5, Parameters

pytestmark = pytest.mark.slow

ALLOWED = 1.5
ONE_CORE = {**os.environ, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}


def processor_time(*arguments: str) -> float:
    """Of one command (s)."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    command = [sys.executable, "-c", "from cosim.cli import main; main()", *arguments]
    subprocess.run(command, check=True, capture_output=True, env=ONE_CORE)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize(
    ("command", "aim"),
    [
        (("margins", "--scenario", "thesis/grasp_centralized_soft"), 10.0),
        (("loss", "--scenario", "thesis/grasp_centralized_soft"), 5.0),
        (("radius", "--scenario", "two_users_box"), 2.5),
    ],
)
def test_a_planar_scenario_is_answered_in_time(command: tuple[str, ...], aim: float) -> None:
    taken = processor_time("theory", *command)
    print(f"{command[0]}: {taken:.2f} s")
    assert taken < ALLOWED * aim


@pytest.mark.parametrize(
    ("rate", "delay", "jitter", "loss"),
    [
        (128, 0.00122, 0.00049, 0.001),
        (128, 0.013975, 0.002368, 0.001),
        (1024, 0.00122, 4.9e-4, 1e-3),
    ],
)
def test_a_design_with_jitter_is_there_in_time(
    rate: int, delay: float, jitter: float, loss: float
) -> None:
    network = Network(Fraction(1, rate), delay, jitter, loss)
    parameters = Parameters("distributed", {}, CHAPTER_5["distributed"], 2)
    taken: list[float] = []
    for _ in range(3):
        begun = time.process_time()
        design(parameters, network, Fraction(1, 1024), 0.25)
        taken.append(time.process_time() - begun)
    print(f"{rate} Hz: {min(taken):.3f} s")
    assert min(taken) < ALLOWED * 0.3
