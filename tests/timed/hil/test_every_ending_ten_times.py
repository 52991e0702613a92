"""One good ending proves little: each of them, ten times, on every board.

All of it, on an idle machine, with two runs beside each other:

    python -m pytest -m slow -n 2 --dist load tests/timed/hil/test_every_ending_ten_times.py

``-k "first or second"`` takes two of the ten.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.hil.ending_table import BOARDS, ENDINGS, end_it

TIMES = [
    "first",
    "second",
    "third",
    "fourth",
    "fifth",
    "sixth",
    "seventh",
    "eighth",
    "ninth",
    "tenth",
]


@pytest.mark.slow
@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("how", ENDINGS)
@pytest.mark.parametrize("board", BOARDS)
def test_the_motors_are_told_zero_in_time(how: str, board: str, time: str, tmp_path: Path):
    del time
    end_it(how, board, tmp_path)
