"""A record of format 1, a dataset for each signal, reads as one of today, digest included."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np

from cosim.base.recording import Column, RecordGroup
from cosim.record import digest, open_run
from cosim.record.rewriting.compact import compact
from tests.support.record.format_1 import write_format_1
from tests.support.record.synthetic_run import write

COLUMNS = (
    Column(name="c.der(x)/dt", unit="m/s", is_float=True, description="ein Maß", causality="local"),
    Column(name="c.mode", unit=None, is_float=False, items=((0, "off"), (1, "on"))),
    Column(name="a.load", unit="N", is_float=True),
    Column(name="a.count", unit="1", is_float=False),
)
RATE = Fraction(10_000, 3)


def test_a_record_of_format_1_reads_as_one_of_today(tmp_path: Path) -> None:
    cells = np.random.default_rng(3).integers(-(2**62), 2**62, (50, len(COLUMNS)))
    cells[:, [0, 2]] = np.random.default_rng(4).normal(size=(50, 2)).view(np.int64)
    group = RecordGroup(name="r", period=3, columns=COLUMNS)
    write_format_1(tmp_path / "old", group, cells, RATE, spare=30)
    write(tmp_path / "new" / "run.h5", (group,), (cells,), base_rate=RATE)
    with open_run(tmp_path / "old") as old, open_run(tmp_path / "new") as new:
        assert old.groups["r"].capacity == 80
        assert digest(old) == digest(new)
        assert list(old.signals) == list(new.signals) == [column.name for column in COLUMNS]
        for column in COLUMNS:
            assert old[column.name].column == new[column.name].column == column
            for rows in (slice(None), slice(5, 9), slice(0, 50, 7)):
                assert (old[column.name][rows] == new[column.name][rows]).all()
        before = digest(old)
    assert compact(tmp_path / "old" / "run.h5"), "an old record is cut, and is one of today then"
    with open_run(tmp_path / "old") as old:
        assert digest(old) == before
        assert old["c.mode"].column == COLUMNS[1]
    with h5py.File(tmp_path / "old" / "run.h5") as file:
        assert file.attrs["format"] == 2


def test_other_readers_find_a_signal_in_the_table(tmp_path: Path) -> None:
    cells = np.arange(40 * len(COLUMNS)).reshape(40, len(COLUMNS))
    group = RecordGroup(name="r", period=1, columns=COLUMNS)
    write(tmp_path / "run.h5", (group,), (cells,))
    with h5py.File(tmp_path / "run.h5") as file:
        table = {entry["name"].decode(): entry for entry in file["r/signals"]}
        for number, column in enumerate(COLUMNS):
            entry = table[column.name]
            values = file["r"][entry["type"].decode()][entry["row"]]
            assert (values.view(np.int64) == cells[:, number]).all()
        assert set(file["r"]) == {"rows", "tick", "signals", "float64", "int64"}
        assert not file["r/float64"].attrs, "no attribute a signal"
