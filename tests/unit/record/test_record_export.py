"""Exports hold the recorded values exactly, and a held signal as it was held."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow.parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.io import loadmat

from cosim.base.errors import InputError
from cosim.base.foxglove.rows import ros_names
from cosim.record import open_run
from cosim.record.export.formats import MATLAB_NAME_LENGTH, export, matlab_names
from cosim.record.export.table import Table


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


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat"])
def test_signals_and_a_window_of_time_are_exported_alone(small_run: Path, kind: str) -> None:
    with open_run(small_run) as run:
        paths = export(run, kind, small_run / "out", patterns=["a.s*", "a.sine"], span=(100, 1000))
        expected = run["a.sine"][100:1000]
        if kind == "csv":
            names, _, rows = read_csv(paths[0])
            assert names == ["tick", "time", "a.sine", "a.state"]
            assert (rows[:, 0] == np.arange(100, 1000)).all()
            found = rows[:, 2]
        elif kind == "parquet":
            found = pyarrow.parquet.read_table(paths[0])["a.sine"].to_numpy()
        else:
            found = loadmat(paths[0], squeeze_me=True, struct_as_record=False)["control"].a_sine
        assert (found == expected).all()


def test_a_window_of_held_rows_begins_with_what_was_held(small_run: Path) -> None:
    with open_run(small_run) as run:
        (path,) = export(
            run, "csv", small_run / "out", held=True, patterns=["lan.held", "a.sine"], span=(13, 20)
        )
        names, _, rows = read_csv(path)
        held = run["lan.held"].values
        expected = [held[tick // 8] for tick in range(13, 20)]
        assert rows[:, names.index("lan.held")].tolist() == expected


def test_a_window_beyond_the_run_and_a_signal_of_no_name_are_refused(small_run: Path) -> None:
    with open_run(small_run) as run:
        with pytest.raises(InputError, match="no row lies in the time"):
            export(run, "csv", small_run / "out", span=(10_000, None))
        with pytest.raises(InputError, match=r"no signal a\.sime was"):
            export(run, "csv", small_run / "out", patterns=["a.sime"])


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


@pytest.mark.filterwarnings("default")
def test_mf4_reads_back_with_units_and_rates(small_run: Path) -> None:
    asammdf = pytest.importorskip("asammdf")
    with open_run(small_run) as run:
        (path,) = export(run, "mf4", small_run / "out")
        with asammdf.MDF(path) as file:
            assert [group.channel_group.acq_name for group in file.groups] == ["control", "network"]
            for name in ("a.ramp", "a.sine", "a.state", "lan.held"):
                signal = file.get(name)
                assert signal.samples.dtype == run[name].values.dtype
                assert (signal.samples == run[name].values).all()
                assert (signal.timestamps == run.seconds(run[name].group.ticks)).all()
            assert file.get("a.sine").unit == "N"
            assert (file.get("tick", group=1).samples == run.groups["network"].ticks).all()


@pytest.mark.filterwarnings("default")
def test_mf4_in_pieces_is_the_same(small_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asammdf = pytest.importorskip("asammdf")
    monkeypatch.setattr(Table, "pieces", in_threes)
    with open_run(small_run) as run:
        (path,) = export(run, "mf4", small_run / "out")
        with asammdf.MDF(path) as file:
            assert (file.get("a.sine").samples == run["a.sine"].values).all()
            assert (file.get("lan.held").samples == run["lan.held"].values).all()


def in_threes(table: Table) -> Iterator[tuple[int, int]]:
    """Three pieces of unequal size."""
    edges = (0, table.rows // 4, table.rows // 2, table.rows)
    yield from pairwise(edges)


@pytest.mark.filterwarnings("default")
def test_mcap_is_read_by_the_ros_2_decoder(small_run: Path) -> None:
    reader = pytest.importorskip("mcap_ros2.reader")
    with open_run(small_run) as run:
        (path,) = export(run, "mcap", small_run / "out")
        seen: dict[str, list[Any]] = {}
        for message in reader.read_ros2_messages(str(path)):
            row = message.ros_msg
            assert message.log_time_ns == row.tick * 10**9 // 1024
            seen.setdefault(message.channel.topic, []).append(row)
        control, network = seen["/control"], seen["/network"]
        assert [row.a_sine for row in control] == run["a.sine"].values.tolist()
        assert [row.a_state for row in control] == run["a.state"].values.tolist()
        assert [row.lan_held for row in network] == run["lan.held"].values.tolist()
        assert [row.tick for row in network] == run.groups["network"].ticks.tolist()


@given(st.lists(st.text(min_size=1, max_size=40), unique=True, max_size=6))
def test_ros_names_are_valid_and_different(names: list[str]) -> None:
    found = ros_names(names)
    assert len(set(found)) == len(names)
    assert all(re.fullmatch(r"[a-z]([a-z0-9]|_(?!_))*(?<!_)", name) for name in found)


def test_an_unknown_format_lists_those_there_are(small_run: Path) -> None:
    with (
        open_run(small_run) as run,
        pytest.raises(InputError, match="mcap, mf4, parquet"),
    ):
        export(run, "xls", small_run / "out")


def test_a_missing_package_is_named(small_run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with open_run(small_run) as run, pytest.raises(InputError, match=r"cohaptic\[export\]"):
        export(run, "parquet", small_run / "out")
