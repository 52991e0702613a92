"""docs/theory.md says up to which remote stiffness the grasp holds, ideally and with FOAW."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from cosim.analysis.answers.asked import ask
from cosim.scenario.load import read
from cosim.thesis.sweeps.breaking import CENTRALIZED, holds

PAGE = " ".join((Path(__file__).parents[3] / "docs" / "theory.md").read_text("utf-8").split())
IDEAL = re.search(
    r"unstable is (\d+) N/m with a window of (1), (\d+) with (4) and (\d+) with (8)", PAGE
)
FOAW = re.search(r"with FOAW starts to oscillate between (\d+) and (\d+) N/m", PAGE)


def radius(stiffness: float, window: int) -> float:
    """Of the ideal run; the tangential coupler's stiffness goes along."""
    server = "components.server.parameters.remote"
    sets = [
        f"{server}_normal_stiffness={stiffness}",
        f"{server}_tangential_stiffness={stiffness * 270 / 170}",
    ]
    with ask(read(CENTRALIZED, (), sets), window=window) as asked:
        return asked.point().spectrum().radius


@pytest.mark.one_in(3)
@pytest.mark.parametrize("number", range(3))
def test_the_ideal_run_becomes_unstable_there(number: int) -> None:
    assert IDEAL is not None
    limit, window = int(IDEAL[2 * number + 1]), int(IDEAL[2 * number + 2])
    assert radius(limit - 1.0, window) < 1.0 < radius(limit + 1.0, window)


def test_with_foaw_and_encoders_it_oscillates_there() -> None:
    """Beside the ideal: FOAW's window adapts, and dry friction holds what would creep."""
    assert FOAW is not None
    assert holds(CENTRALIZED, 1, stiffness=int(FOAW[1]))
    assert not holds(CENTRALIZED, 1, stiffness=int(FOAW[2]))
