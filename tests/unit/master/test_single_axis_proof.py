"""The proof: co-simulated single-axis systems are the lifted multi-rate model, to 1e-9."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.master.lifted_model import Fate, simulate
from tests.support.master.master_support import run
from tests.support.master.single_axis import (
    ARCHITECTURES,
    BODIES,
    GAINS,
    PLACES,
    STEP,
    Gains,
    lifted,
    single_axis,
)

FRAMES = 128
"""One second of network samples."""


def error_of(
    folder: Path, name: str, gains: Gains, channel: Any, fates: Any
) -> tuple[float, float]:
    """Largest difference between co-simulation and lifted model, and the largest signal."""
    initial = [value for body in BODIES[name] for value in PLACES[body]]
    expected = simulate(lifted(name, gains), initial, STEP, fates, FRAMES)
    sink, _ = run(single_axis(folder, name, gains, channel))
    quantities = ("position", "velocity")
    actual = np.column_stack([sink.signal(f"{b}.{q}") for b in BODIES[name] for q in quantities])
    assert actual.shape == expected.shape
    return float(np.abs(actual - expected).max()), float(np.abs(expected).max())


@pytest.mark.parametrize("name", ARCHITECTURES)
@pytest.mark.parametrize("gains", ["soft", "stiff"])
@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_co_simulation_is_the_lifted_model(tmp_path: Path, name: str, gains: str, n: int) -> None:
    there, back = (n + 1) // 2, n // 2
    fates = ([there] * FRAMES, [back] * FRAMES)
    error, peak = error_of(tmp_path, name, GAINS[name][gains], {"round_trip_delay": n}, fates)
    assert error <= 1e-9 * max(1.0, peak)
    if gains == "stiff" and n >= 1:
        assert peak > 100.0, "the unstable set must really be unstable"


def lossy(seed: int, delays: Sequence[int]) -> list[Fate]:
    """One packet in five lost, the others delayed at random."""
    random = np.random.default_rng(seed)
    lost = random.random(FRAMES) < 0.2
    drawn = random.choice(delays, FRAMES)
    return [None if gone else int(delay) for gone, delay in zip(lost, drawn, strict=True)]


@pytest.mark.parametrize("name", ARCHITECTURES)
@pytest.mark.parametrize("gains", ["soft", "stiff"])
@pytest.mark.parametrize("delays", [(0, 1, 2), (1, 2, 3, 5)])
def test_so_it_is_under_a_trace_of_loss_and_jitter(
    tmp_path: Path, name: str, gains: str, delays: tuple[int, ...]
) -> None:
    fates = (lossy(1, delays), lossy(2, delays))
    written = [["lost" if fate is None else fate for fate in way] for way in fates]
    channel = {"trace": {"forward": written[0], "backward": written[1]}}
    error, peak = error_of(tmp_path, name, GAINS[name][gains], channel, fates)
    assert error <= 1e-9 * max(1.0, peak)


@pytest.mark.parametrize("name", ARCHITECTURES)
def test_so_it_is_under_drawn_loss_and_jitter(tmp_path: Path, name: str) -> None:
    """What was delivered is read back from the recorded sequence numbers."""
    channel = {"round_trip_delay": 2, "loss": 0.2, "jitter": 2}
    gains = GAINS[name]["soft"]
    sink, _ = run(single_axis(tmp_path, name, gains, channel))
    fates: list[list[Fate]] = []
    for way in ("forward", "backward"):
        fate: list[Fate] = [None] * FRAMES
        for frame, held in enumerate(sink.signal(f"lan.{way}.sequence")[::8].tolist()):
            if held >= 0 and fate[held] is None:
                fate[held] = frame - held
        assert {None, 1, 2, 3} == set(fate)
        fates.append(fate)
    error, peak = error_of(tmp_path, name, gains, channel, fates)
    assert error <= 1e-9 * max(1.0, peak)
