"""Whatever is committed comes back bit for bit, with its ticks, in whatever pieces it came."""

from __future__ import annotations

import tempfile
from fractions import Fraction
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cosim.base.errors import InputError
from cosim.base.recording import Column, RecordGroup
from cosim.record import layout, open_run
from cosim.record.signals import RecordedSignal
from tests.support.record.synthetic_run import write

ANY_BITS = st.integers(-(2**63), 2**63 - 1)


@settings(deadline=None, max_examples=40)
@given(st.data())
def test_every_bit_and_every_tick_comes_back(data: st.DataObject) -> None:
    kinds = data.draw(st.lists(st.booleans(), min_size=1, max_size=4))
    period = data.draw(st.integers(1, 9))
    rows = data.draw(st.integers(0, 200))
    spare = data.draw(st.integers(0, 300))
    cells = data.draw(hnp.arrays(np.int64, (rows, len(kinds)), elements=ANY_BITS))
    pieces = data.draw(st.lists(st.integers(1, 70), max_size=20))
    columns = tuple(
        Column(name=f"c.x[{i}]", unit="N.m", is_float=kind) for i, kind in enumerate(kinds)
    )
    with tempfile.TemporaryDirectory() as folder:
        recorder = write(
            Path(folder) / "run.h5",
            (RecordGroup(name="control", period=period, columns=columns),),
            (cells,),
            rows_at_a_time=pieces,
            ticks=(rows + spare) * period,
        )
        assert recorder.rows == (rows,)
        with open_run(folder) as run:
            group = run.groups["control"]
            assert group.ticks.tolist() == [period * row for row in range(rows)]
            assert list(group.signals) == [column.name for column in columns]
            for index, column in enumerate(columns):
                signal = run[column.name]
                assert signal.unit == "N.m"
                assert signal.values.dtype == (np.float64 if column.is_float else np.int64)
                assert signal.values.tobytes() == cells[:, index].tobytes()


@pytest.mark.parametrize("rows", [1, 99, 100, 101, 1000, 1024])
def test_a_column_may_lie_in_several_segments(
    rows: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(layout, "SEGMENT_ROWS", 100)
    cells = np.arange(rows * 3).reshape(rows, 3)
    columns = tuple(Column(name=f"c.x{i}", unit=None, is_float=False) for i in range(3))
    write(
        tmp_path / "run.h5",
        (RecordGroup(name="r", period=1, columns=columns),),
        (cells,),
        ticks=1024,
    )
    with open_run(tmp_path) as run:
        assert run.groups["r"].rows == rows
        for index in range(3):
            assert (run[f"c.x{index}"].values == cells[:, index]).all()
    with h5py.File(tmp_path / "run.h5") as file:  # trimmed for every other reader too
        assert file["r/int64"].shape == (3, rows)
        assert file["r/tick"].shape == (rows,)


def test_the_base_rate_is_an_exact_fraction(tmp_path: Path) -> None:
    column = Column(name="c.x", unit=None, is_float=True)
    write(
        tmp_path / "run.h5",
        (RecordGroup(name="r", period=3, columns=(column,)),),
        (np.zeros((4, 1), np.int64),),
        base_rate=Fraction(10_000, 3),
    )
    with open_run(tmp_path) as run:
        assert run.base_rate == Fraction(10_000, 3)
        assert run.groups["r"].rate == Fraction(10_000, 9)
        assert run.groups["r"].time.tolist() == [tick * 3 / 10_000 for tick in (0, 3, 6, 9)]


def test_a_name_with_a_slash_is_one_signal(tmp_path: Path) -> None:
    group = RecordGroup(
        name="r", period=1, columns=(Column(name="c.der(x)/dt", unit=None, is_float=True),)
    )
    write(tmp_path / "run.h5", (group,), (np.zeros((4, 1), np.int64),))
    with open_run(tmp_path) as run:
        assert list(run.signals) == ["c.der(x)/dt"]


def test_slices_read_what_numpy_would(small_run: Path) -> None:
    with open_run(small_run) as run:
        ramp = run["a.ramp"]
        for rows in (slice(5, 9), slice(-3, None), slice(0, 5000, 100), slice(7, 7)):
            assert (ramp[rows] == ramp.values[rows]).all()
        assert (np.concatenate(list(ramp.blocks(3, 1500))) == ramp.values[3:1500]).all()


def test_an_unknown_signal_says_what_comes_near(small_run: Path) -> None:
    with open_run(small_run) as run, pytest.raises(InputError, match=r"a\.ramp"):
        run["a.rump"]


def test_what_is_not_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"not a run folder"):
        open_run(tmp_path)
    (tmp_path / "run.h5").write_bytes(b"no HDF5 at all")
    with pytest.raises(InputError, match="not a readable HDF5 file"):
        open_run(tmp_path)
    with h5py.File(tmp_path / "run.h5", "w") as file:
        file["x"] = 1
    with pytest.raises(InputError, match="not a run record"):
        open_run(tmp_path)


def test_reading_one_signal_describes_no_other(
    small_run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[str] = []

    class Watched(RecordedSignal):
        def __init__(self, *arguments: Any) -> None:
            super().__init__(*arguments)
            made.append(self.name)

    monkeypatch.setattr("cosim.record.signals.RecordedSignal", Watched)
    with open_run(small_run) as run:
        assert "a.ramp" in run
        assert len(run.signals) > 2
        assert made == []
        assert run["a.sine"].values.size
    assert made == ["a.sine"]
