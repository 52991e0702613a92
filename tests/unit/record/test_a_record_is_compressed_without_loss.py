"""A compressed record has every bit of the plain one; an interrupted compression harms none."""

from __future__ import annotations

import stat
import sys
import tempfile
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cosim.base.errors import InputError, RunError
from cosim.base.recording import Column, RecordGroup
from cosim.cli.record import command
from cosim.record import digest, open_run
from cosim.record.reader import RUN_FILE
from cosim.record.rewriting.compression import compress, is_compressed, write_compressed
from cosim.record.writer import Recorder
from tests.support.record.synthetic_run import write

ANY_BITS = st.integers(-(2**63), 2**63 - 1)


def digest_of(folder: Path) -> str:
    with open_run(folder) as run:
        return digest(run)


@settings(deadline=None, max_examples=15)
@given(st.data())
def test_every_bit_is_there(data: st.DataObject) -> None:
    kinds = data.draw(st.lists(st.booleans(), min_size=1, max_size=3))
    rows = data.draw(st.sampled_from([0, 1, 7, 8191, 8192, 8200]))
    period = data.draw(st.integers(1, 9))
    fill = data.draw(hnp.arrays(np.int64, (min(rows, 20), len(kinds)), elements=ANY_BITS))
    cells = np.resize(fill, (rows, len(kinds))) if rows else fill
    columns = tuple(Column(name=f"c.x[{i}]", unit="m", is_float=k) for i, k in enumerate(kinds))
    with tempfile.TemporaryDirectory() as folder:
        plain, packed = Path(folder) / "plain" / RUN_FILE, Path(folder) / "packed" / RUN_FILE
        write(
            plain,
            (RecordGroup(name="control", period=period, columns=columns),),
            (cells,),
            rows_at_a_time=[3000],
        )
        packed.parent.mkdir()
        write_compressed(plain, packed)
        assert digest_of(packed.parent) == digest_of(plain.parent)
        with open_run(plain) as one, open_run(packed) as other:
            assert other.groups["control"].rows == rows
            for name, signal in one.signals.items():
                assert other[name].column == signal.column
                assert np.array_equal(other[name].cells(0, rows), signal.cells(0, rows))


def test_it_is_smaller_and_says_so(small_run: Path) -> None:
    before = digest_of(small_run)
    size = (small_run / RUN_FILE).stat().st_size
    done = CliRunner().invoke(command, ["compress", str(small_run)], catch_exceptions=False)
    assert done.exit_code == 0
    assert "MB before" in done.stdout
    assert digest_of(small_run) == before
    assert (small_run / RUN_FILE).stat().st_size < size
    assert is_compressed(small_run / RUN_FILE)
    again = CliRunner().invoke(command, ["compress", str(small_run)], catch_exceptions=False)
    assert "compressed already" in again.stdout
    with h5py.File(small_run / RUN_FILE) as file:  # read everywhere
        values = file["control/float64"]
        assert (values.compression, values.compression_opts, values.shuffle) == ("gzip", 1, True)


def killed(folder: Path) -> Path:
    """A Python that is killed when half a copy is written."""
    path = folder / "python"
    path.write_text('#!/bin/sh\nprintf half > "$4"\nkill -9 $$\n')
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return path


def test_a_compression_that_is_killed_changes_nothing(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (small_run / RUN_FILE).read_bytes()
    files = set(small_run.iterdir())
    monkeypatch.setattr(sys, "executable", str(killed(tmp_path)))
    with pytest.raises(RunError, match="is as it was: its process ended with status -9"):
        compress(small_run)
    assert (small_run / RUN_FILE).read_bytes() == before
    assert set(small_run.iterdir()) == files


def test_a_copy_that_is_not_equal_is_not_kept(
    small_run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = (small_run / RUN_FILE).read_bytes()
    other = tmp_path / "other" / RUN_FILE
    column = Column(name="a.ramp", unit="m", is_float=True)
    write(
        other,
        (RecordGroup(name="control", period=1, columns=(column,)),),
        (np.zeros((4, 1), np.int64),),
    )
    stub = tmp_path / "python"
    stub.write_text(f'#!/bin/sh\ncp {other} "$4"\n')
    stub.chmod(stub.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setattr(sys, "executable", str(stub))
    with pytest.raises(RunError, match="another digest"):
        compress(small_run)
    assert (small_run / RUN_FILE).read_bytes() == before


def test_a_run_that_may_still_go_on_is_left_alone(tmp_path: Path) -> None:
    columns = (Column(name="a.x", unit="m", is_float=True),)
    path = tmp_path / RUN_FILE
    recorder = Recorder(path, 100)
    recorder.begin((RecordGroup(name="control", period=1, columns=columns),), Fraction(1024))
    try:
        with pytest.raises(InputError, match="still going on"):
            compress(tmp_path)
    finally:
        recorder.close()
