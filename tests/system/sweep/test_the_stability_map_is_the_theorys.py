"""Delay and stiffness, both architectures: simulated runs calm down where the theory says so.

The README's picture is drawn from numbers that its commands give. Cells that the boundary crosses
may go either way, and their neighbours: a run is finite.
"""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim.sweep.theory import is_stable
from tests.support.guide.stability_map import (
    NUMBERS,
    PICTURE,
    digest,
    judged,
    kept,
    lines,
    panel_from,
    run,
    wrong,
)

COMMANDS = lines()
STORED: dict[str, Any] = json.loads(NUMBERS.read_text())
SMALLER = {"0..39": "0..7", "/40 log": "/6 log", "duration=6 s": "duration=3 s"}


def smaller(arguments: list[str]) -> list[str]:
    """A map of 8 × 6 cells, of half as long runs."""
    for written, other in SMALLER.items():
        assert any(written in each for each in arguments)
        arguments = [each.replace(written, other) for each in arguments]
    return arguments


def alone(arguments: list[str], delay: int, stiffness: float) -> list[str]:
    """One cell of the map."""
    found = [each.replace("0..39", str(delay)) for each in arguments]
    return [f"{each.partition('=')[0]}={stiffness!r}" if " log" in each else each for each in found]


def test_the_picture_is_of_both_architectures_and_drawn_from_what_is_kept() -> None:
    assert list(COMMANDS) == list(STORED) == ["distributed", "centralized"]
    made = "python -m tests.support.guide.stability_map makes it"
    assert digest(NUMBERS.read_bytes()).encode() in PICTURE.read_bytes(), made


@pytest.mark.parametrize("architecture", COMMANDS)
def test_what_is_kept_agrees_with_the_theory(architecture: str) -> None:
    panel = panel_from(STORED[architecture])
    assert panel.radii is not None
    good, stable = panel.shares == 1.0, np.vectorize(is_stable)(panel.radii)
    assert good.shape == (40, 40)
    assert wrong(good, stable) == []
    assert 0.05 < stable.mean() < 0.95
    # A boundary two cells off, or that of other delays, is seen.
    assert wrong(good, np.roll(stable, 2, axis=1)) != []
    assert wrong(good[:, ::-1], stable) != []


@pytest.mark.parametrize("architecture", COMMANDS)
def test_what_is_kept_is_what_a_run_of_the_cell_gives(architecture: str, tmp_path: Path) -> None:
    """Of cells at the boundary and of some others; ``slow`` runs them all."""
    panel = panel_from(STORED[architecture])
    assert panel.radii is not None
    near = np.argsort(np.abs(panel.radii.ravel() - 1.0), kind="stable")[:4]
    for number, cell in enumerate((*near, 0, 1599, 812)):
        row, column = divmod(int(cell), 40)
        arguments = alone(
            COMMANDS[architecture], int(panel.across.values[column]), float(panel.up.values[row])
        )
        outcome = run(arguments, tmp_path / str(number), 0)
        [result] = outcome.results
        assert outcome.theory is not None
        assert outcome.theory[0] == pytest.approx(panel.radii[row, column], rel=1e-5)
        assert result.is_good == (panel.shares[row, column] == 1.0), (row, column)


@pytest.mark.parametrize("architecture", COMMANDS)
def test_a_coarse_map_agrees(architecture: str, tmp_path: Path) -> None:
    good, stable = judged(run(smaller(COMMANDS[architecture]), tmp_path / "map", 0))
    assert good.shape == (6, 8)
    assert wrong(good, stable) == []
    assert 0 < stable.sum() < stable.size
    # Against the theory of other delays it does not.
    assert wrong(good, stable[:, ::-1]) != []


@pytest.mark.slow
def test_the_command_gives_what_is_kept_within_a_minute(tmp_path: Path) -> None:
    began, before = time.monotonic(), os.times()
    for architecture, arguments in COMMANDS.items():
        outcome = run(arguments, tmp_path / architecture, 2)
        assert kept(outcome) == STORED[architecture]
    used = sum(os.times()[:4]) - sum(before[:4])
    # On two processors, as far as they were ours.
    assert min(time.monotonic() - began, used / 2) < 60
