"""Exports hold the recorded values exactly, and a held signal as it was held."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import loadmat

from cosim.errors import InputError
from cosim.record import open_run
from cosim.record.export import MATLAB_NAME_LENGTH, export, matlab_names


def read_csv(path: Path) -> tuple[list[str], list[str], np.ndarray]:
    with path.open(newline="") as file:
        names, units, *rows = csv.reader(file)
    return names, units, np.array(rows, dtype=float)


def test_csv_reads_back_to_the_same_doubles(small_run: Path) -> None:
    with open_run(small_run) as run:
        control, network = export(run, "csv", small_run / "out")
        names, units, rows = read_csv(control)
        assert names == ["tick", "time", "a.ramp", "a.sine", "a.state"]
        assert units == ["1", "s", "m", "N", "1"]
        for index, name in enumerate(names[2:], start=2):
            assert (rows[:, index] == run[name].values).all()
        assert len(read_csv(network)[2]) == 256


def test_a_slow_signal_is_held_not_interpolated(small_run: Path) -> None:
    with open_run(small_run) as run:
        (path,) = export(run, "csv", small_run / "out", held=True)
        names, _, rows = read_csv(path)
        held = rows[:, names.index("lan.held")]
        assert (held == np.repeat(run["lan.held"].values, 8)).all()
        assert (rows[:, 0] == np.arange(2048)).all()


def test_parquet_keeps_types_units_and_rates(small_run: Path) -> None:
    with open_run(small_run) as run:
        paths = export(run, "parquet", small_run / "out")
        table: Any = pyarrow.parquet.read_table(paths[0])
        assert table.schema.metadata == {b"base_rate": b"1024", b"period": b"1"}
        assert table.schema.field("a.sine").metadata[b"unit"] == b"N"
        assert (table["a.sine"].to_numpy() == run["a.sine"].values).all()
        assert table["a.state"].to_numpy().dtype == np.int64
        assert (table["tick"].to_numpy() == run.groups["control"].ticks).all()


def test_mat_has_a_struct_for_each_rate(small_run: Path) -> None:
    with open_run(small_run) as run:
        (path,) = export(run, "mat", small_run / "out")
        content = loadmat(path, squeeze_me=True, struct_as_record=False)
        assert (content["control"].a_sine == run["a.sine"].values).all()
        assert content["control"].units.a_ramp == "m"
        assert content["control"].names.a_ramp == "a.ramp"
        assert (content["network"].lan_held == run["lan.held"].values).all()
        assert content["base_rate"].tolist() == [1024, 1]


@given(st.lists(st.text(min_size=1, max_size=90), unique=True, max_size=6))
def test_matlab_names_are_valid_and_different(names: list[str]) -> None:
    found = matlab_names(names)
    assert len(set(found)) == len(names)
    for name in found:
        assert name.isidentifier()
        assert name.isascii()
        assert name[0].isalpha()
        assert len(name) <= MATLAB_NAME_LENGTH


def test_an_unknown_format_lists_those_there_are(small_run: Path) -> None:
    with open_run(small_run) as run, pytest.raises(InputError, match="csv, mat, parquet"):
        export(run, "xls", small_run / "out")


def test_a_missing_package_is_named(small_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with open_run(small_run) as run, pytest.raises(InputError, match=r"cohaptic\[export\]"):
        export(run, "parquet", small_run / "out")
