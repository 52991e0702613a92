"""What a reader gets is what was written, whole and in order, or counted as lost."""

from __future__ import annotations

import os

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.realtime.ring import Reader, Ring


@settings(deadline=None, max_examples=60)
@given(st.lists(st.one_of(st.integers(1, 20), st.none()), max_size=30))
def test_every_record_is_read_once_or_counted_lost(actions):
    ring = Ring.create(3, capacity=8)
    try:
        reader, written, read = Reader(Ring(ring.path)), 0, []
        for action in actions:
            if action is None:
                read += [row.tolist() for row in reader.read()]
            else:
                for _ in range(action):
                    ring.write((written, -written, 0.5))
                    written += 1
        read += [row.tolist() for row in reader.read()]
        assert len(read) + reader.lost == written
        numbers = [row[0] for row in read]
        assert numbers == sorted(set(numbers))
        assert all(row == [row[0], -row[0], 0.5] for row in read)
        assert numbers[-8:] == list(range(max(0, written - 8), written))[-len(numbers[-8:]) :]
    finally:
        ring.remove()


def test_a_reader_in_another_process_never_sees_a_torn_record():
    ring = Ring.create(16, capacity=4)
    try:
        reader, last, seen = Reader(ring), -1.0, 0
        child = os.fork()
        if child == 0:
            mine = Ring(ring.path)
            for number in range(20_000):
                mine.write(np.full(16, float(number)))
            os._exit(0)
        while True:
            for row in reader.read():
                assert (row == row[0]).all()
                assert row[0] > last
                last, seen = row[0], seen + 1
            done, status = os.waitpid(child, os.WNOHANG)
            if done:
                break
        for row in reader.read():
            last, seen = row[0], seen + 1
        assert status == 0
        assert seen + reader.lost == ring.written == 20_000
        assert last == 19_999
    finally:
        ring.remove()


def test_something_else_is_no_ring(tmp_path):
    (tmp_path / "x").write_bytes(bytes(4096))
    with pytest.raises(FileNotFoundError, match="no ring"):
        Ring(tmp_path / "x")
