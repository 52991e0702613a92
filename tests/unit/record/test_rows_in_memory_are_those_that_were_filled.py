"""A sink in memory keeps the rows that were filled, whatever room was asked for."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.base.recording import Column, MemorySink, RecordGroup

WIDTHS = (1, 3, 2000)
"""Columns of each group; of the widest, 100 rows are more than a megabyte."""


def group(width: int) -> RecordGroup:
    columns = tuple(Column(name=f"c.{n}", unit=None, is_float=False) for n in range(width))
    return RecordGroup(name=f"of {width}", period=1, columns=columns)


@settings(max_examples=20, deadline=None)
@given(
    st.lists(
        st.tuples(st.integers(0, len(WIDTHS) - 1), st.integers(1, 60), st.integers(0, 60)),
        max_size=40,
    )
)
def test_rows_follow_each_other(asked: list[tuple[int, int, int]]) -> None:
    sink = MemorySink()
    for _ in range(2):  # a sink that begins again has forgotten what was there
        sink.begin([group(width) for width in WIDTHS], Fraction(1000))
        filled = [0] * len(WIDTHS)
        for number, room, wanted in asked:
            count = min(room, wanted)
            rows = sink.buffer(number, room)
            assert rows.shape == (room, WIDTHS[number])
            rows[:] = -1
            first = filled[number]
            rows[:count] = np.arange(first, first + count)[:, np.newaxis]
            sink.commit(number, first, count)
            filled[number] += count
        for number, width in enumerate(WIDTHS):
            expected = np.repeat(np.arange(filled[number])[:, np.newaxis], width, axis=1)
            np.testing.assert_array_equal(sink.rows(number), expected)
