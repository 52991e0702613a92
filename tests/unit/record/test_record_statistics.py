"""Statistics and envelopes taken block by block are those of the whole column."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cosim.record.statistics import ENVELOPE_BINS, ColumnStatistics

MODERATE = st.floats(-1e6, 1e6) | st.just(float("nan"))


def feed(statistics: ColumnStatistics, cells: np.ndarray, cuts: list[int]) -> None:
    for block in np.split(cells, sorted(cuts), axis=1):
        statistics.update(np.ascontiguousarray(block))


@settings(deadline=None, max_examples=100)
@given(st.data())
def test_blocks_give_what_numpy_gives_for_the_whole(data: st.DataObject) -> None:
    rows = data.draw(st.integers(1, 60))
    floats = data.draw(hnp.arrays(np.float64, (2, rows), elements=MODERATE))
    integers = data.draw(hnp.arrays(np.int64, (2, rows), elements=st.integers(-(2**40), 2**40)))
    cells = np.stack([integers[0], floats[0].view(np.int64), integers[1], floats[1].view(np.int64)])
    statistics = ColumnStatistics(np.array([False, True, False, True]), rows)
    feed(statistics, cells, data.draw(st.lists(st.integers(0, rows), max_size=6)))
    columns = [integers[0].astype(float), floats[0], integers[1].astype(float), floats[1]]
    for index, column in enumerate(columns):
        found = statistics[index]
        numbers = column[~np.isnan(column)]
        assert (found.rows, found.missing) == (rows, rows - numbers.size)
        assert found.changes == np.count_nonzero(np.diff(cells[index]))
        if not numbers.size:
            assert np.isnan([found.minimum, found.maximum, found.mean, found.rms]).all()
            continue
        size = max(1.0, float(np.abs(numbers).max()))
        assert found.minimum == numbers.min()
        assert found.maximum == numbers.max()
        assert found.mean == pytest.approx(numbers.mean(), abs=1e-12 * size)
        assert found.std == pytest.approx(numbers.std(), abs=1e-7 * size, rel=1e-9)
        assert found.rms == pytest.approx(np.sqrt((numbers**2).mean()), abs=1e-7 * size)


def test_a_small_ripple_on_a_large_offset_is_not_cancelled_away() -> None:
    ripple = 1e-6 * np.sin(np.arange(5000.0))
    statistics = ColumnStatistics(np.array([True]), 5000)
    feed(statistics, (1e6 + ripple).view(np.int64)[None], list(range(100, 5000, 100)))
    assert statistics[0].std == pytest.approx((1e6 + ripple - 1e6).std(), rel=1e-3)


@settings(deadline=None, max_examples=50)
@given(
    st.integers(1, 5 * ENVELOPE_BINS),
    st.integers(0, 2000),
    st.lists(st.floats(0, 1), max_size=5),
    st.integers(0, 2**32 - 1),
)
def test_the_envelope_holds_each_bins_extremes(
    rows: int, spare: int, cuts: list[float], seed: int
) -> None:
    values = np.random.default_rng(seed).normal(size=rows)
    statistics = ColumnStatistics(np.array([True]), rows + spare)
    feed(statistics, values.view(np.int64)[None], [int(cut * rows) for cut in cuts])
    summary = statistics.summary(0)
    lows, highs = summary.lows, summary.highs
    width = statistics.rows_per_bin
    bins = [values[first : first + width] for first in range(0, rows, width)]
    assert lows.tolist() == [part.min() for part in bins]
    assert highs.tolist() == [part.max() for part in bins]
    assert lows.size <= ENVELOPE_BINS
