"""One good ending proves little: each of them, ten times, on every board."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.hil.ending_table import BOARDS, ENDINGS, end_it

TIMES = 10


@pytest.mark.slow
@pytest.mark.parametrize("number", range(TIMES))
@pytest.mark.parametrize("how", ENDINGS)
@pytest.mark.parametrize("board", BOARDS)
def test_the_motors_are_told_zero_in_time(how: str, board: str, number: int, tmp_path: Path):
    end_it(how, board, tmp_path)
