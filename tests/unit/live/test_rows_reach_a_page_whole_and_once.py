"""Every viewer has each row once, whenever it asks; what is too much keeps its peaks."""

from __future__ import annotations

from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.live.followed import POINTS, Followed
from cosim.realtime.live import Feed
from cosim.realtime.ring import Reader, Ring

COLUMNS = [
    SimpleNamespace(name="a.force", unit="N", is_float=True),
    SimpleNamespace(name="a.state", unit=None, is_float=False),
]

START = 100.0
"""Model time (s) of tick 0."""


@pytest.fixture
def run() -> Iterator[tuple[Followed, Ring]]:
    ring = Ring.create(2, capacity=8192)
    feed = Feed("bench", 1000.0, {}, [ring], start=START)
    feed.publish([SimpleNamespace(name="control", period=1, columns=COLUMNS)])
    followed = Followed(feed.path)
    yield followed, ring
    followed.close()
    feed.remove()
    ring.remove()


def rows(values: np.ndarray) -> np.ndarray:
    cells = np.stack([values.astype(float), np.zeros(len(values))], axis=1).view(np.int64)
    cells[:, 1] = np.arange(len(values)) % 4
    return cells


def test_two_viewers_have_the_same_rows_however_often_they_ask(
    run: tuple[Followed, Ring],
) -> None:
    followed, ring = run
    quick: dict[int, int] = {}
    slow: dict[int, int] = {}
    for seen in (quick, slow):
        assert followed.since(["a.force"], seen) == []
    found: list[float] = []
    for part in np.split(np.arange(200.0), 10):
        ring.extend(rows(part))
        followed.read()
        for entry in followed.since(["a.force", "a.state"], quick):
            found += entry["y"]["a.force"]
    (late,) = followed.since(["a.force", "a.state"], slow)
    assert found == late["y"]["a.force"] == np.arange(200.0).tolist()
    assert late["t"] == pytest.approx((START + np.arange(200) / 1000).tolist())
    assert late["y"]["a.state"][:5] == [0, 1, 2, 3, 0]
    assert followed.newest() == []
    assert followed.time == pytest.approx(START + 0.199)


@given(chunks=st.lists(st.integers(0, 2500), max_size=12))
def test_of_chunks_of_any_size_the_newest_two_seconds_are_kept(chunks: list[int]) -> None:
    ring = Ring.create(2, capacity=4096)
    feed = Feed("bench", 1000.0, {}, [ring])
    feed.publish([SimpleNamespace(name="control", period=1, columns=COLUMNS)])
    followed = Followed(feed.path)
    count = 0
    for chunk in chunks:
        ring.extend(rows(np.arange(count, count + chunk)))
        count += chunk
        followed.read()
        first, period, cells = followed.rows_since(0, {0: 0})
        assert (first, period) == (max(0, count - 2000), 1)
        assert cells[:, 0].tolist() == list(range(first, count))
    followed.close()
    feed.remove()
    ring.remove()


def test_many_rows_at_once_keep_every_peak(run: tuple[Followed, Ring]) -> None:
    followed, ring = run
    seen: dict[int, int] = {}
    followed.since(["a.force"], seen)
    values = np.zeros(1900)
    values[777], values[1234] = 5.0, -7.0
    ring.extend(rows(values))
    followed.read()
    (entry,) = followed.since(["a.force"], seen)
    drawn = entry["y"]["a.force"]
    assert len(drawn) == len(entry["t"]) <= POINTS + 2
    assert max(drawn) == 5.0
    assert min(drawn) == -7.0


def test_what_is_no_number_is_not_drawn(run: tuple[Followed, Ring]) -> None:
    followed, ring = run
    seen: dict[int, int] = {}
    followed.since(["a.force"], seen)
    ring.extend(rows(np.array([1.0, np.nan, np.inf, 2.0])))
    followed.read()
    (entry,) = followed.since(["a.force"], seen)
    assert entry["y"]["a.force"] == [1.0, None, None, 2.0]


@given(st.lists(st.integers(0, 40), max_size=12), st.integers(1, 16))
def test_rows_in_blocks_are_the_same_records_as_one_by_one(
    blocks: list[int], capacity: int
) -> None:
    one, many = Ring.create(1, capacity), Ring.create(1, capacity)
    try:
        readers = [Reader(ring) for ring in (one, many)]
        value = 0
        for size in blocks:
            cells = np.arange(value, value + size, dtype=np.int64).reshape(-1, 1)
            value += size
            many.extend(cells)
            for row in cells:
                one.put(memoryview(row.tobytes()).cast("q"))
            left, right = (reader.read() for reader in readers)
            assert np.array_equal(left.view(np.int64), right.view(np.int64))
            assert readers[0].lost == readers[1].lost
    finally:
        one.remove()
        many.remove()
