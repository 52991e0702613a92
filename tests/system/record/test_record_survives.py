"""Whatever ends a run, everything up to the last flush can be read, by any HDF5 reader."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from fractions import Fraction
from pathlib import Path

import h5py
import numpy as np
import pytest

from cosim.base.errors import RunError
from cosim.base.recording import Column, RecordGroup
from cosim.record import open_run, writer
from cosim.record.writer import Recorder
from tests.support.record.synthetic_run import small_disk

COLUMNS = 20
GROUP = RecordGroup(
    name="control",
    period=1,
    columns=tuple(
        Column(name=f"c.x[{index}]", unit=None, is_float=False) for index in range(COLUMNS)
    ),
)

# Cell (row, column) is row * COLUMNS + column, so that any prefix can be checked.
RUN_FOR_EVER = """
import sys, time
import numpy as np
from fractions import Fraction
from pathlib import Path
from cosim.base.recording import Column, RecordGroup
from cosim.record.writer import Recorder

columns = int(sys.argv[2])
group = RecordGroup(name="control", period=1, columns=tuple(
    Column(name=f"c.x[{i}]", unit=None, is_float=False) for i in range(columns)))
recorder = Recorder(Path(sys.argv[1]), 10_000_000)
recorder.begin((group,), Fraction(1024))
row = 0
while True:
    cells = recorder.buffer(0, 256)
    cells[:] = np.arange(row * columns, (row + 256) * columns).reshape(256, columns)
    recorder.commit(0, row, 256)
    row += 256
    if row > 20_000:
        sys.stdout.write("far enough\\n")
        sys.stdout.flush()
        time.sleep(0.001)
"""


def check_prefix(folder: Path, *, at_least: int) -> int:
    """Every recorded row is what was committed; returns how many there are."""
    with open_run(folder) as run:
        group = run.groups["control"]
        rows = group.rows
        assert rows >= at_least
        assert (group.ticks == np.arange(rows)).all()
        for index in range(COLUMNS):
            expected = np.arange(rows) * COLUMNS + index
            assert (run[f"c.x[{index}]"].values == expected).all()
    return rows


@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGSEGV])
def test_a_killed_process_leaves_a_readable_file(ending: signal.Signals, tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with subprocess.Popen(
        [sys.executable, "-c", RUN_FOR_EVER, str(path), str(COLUMNS)],
        stdout=subprocess.PIPE,
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"far enough\n"
        time.sleep(0.05)
        process.send_signal(ending)
        process.communicate()
        assert process.returncode == -ending
    # At most the blocks of the pool are missing.
    rows = check_prefix(tmp_path, at_least=20_000 - writer.BLOCKS * writer.BLOCK_ROWS[1])
    with h5py.File(path) as file:  # nothing to repair first, for readers that are not ours
        assert file["control/rows"][()] == rows
        assert (file["control/int64"][3, :rows] == np.arange(rows) * COLUMNS + 3).all()


def test_a_run_can_be_read_while_it_goes_on(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "run.h5", 100_000)
    recorder.begin((GROUP,), Fraction(1024))
    row = 0
    while row < 30_000:
        cells = recorder.buffer(0, 500)
        cells[:] = np.arange(row * COLUMNS, (row + 500) * COLUMNS).reshape(500, COLUMNS)
        recorder.commit(0, row, 500)
        row += 500
    check_prefix(tmp_path, at_least=1)
    recorder.close()
    assert check_prefix(tmp_path, at_least=30_000) == 30_000


def test_an_error_in_the_loop_keeps_every_committed_row(tmp_path: Path) -> None:
    def record_and_fail() -> None:
        with Recorder(tmp_path / "run.h5", 100_000) as recorder:
            recorder.begin((GROUP,), Fraction(1024))
            recorder.buffer(0, 7)[:] = np.arange(7 * COLUMNS).reshape(7, COLUMNS)
            recorder.commit(0, 0, 7)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        record_and_fail()
    assert check_prefix(tmp_path, at_least=7) == 7


def test_a_slow_run_is_flushed_by_the_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "FLUSH_SECONDS", 0.01)
    with Recorder(tmp_path / "run.h5", 1000) as recorder:
        recorder.begin((GROUP,), Fraction(1024))
        for row in range(3):
            recorder.buffer(0, 1)[:] = np.arange(row * COLUMNS, (row + 1) * COLUMNS)
            recorder.commit(0, row, 1)
            time.sleep(0.02)
        while recorder.rows[0] < 2:  # for ever, were there no flush: the suite's limit ends it
            time.sleep(0.01)
        check_prefix(tmp_path, at_least=2)


FILL_THE_DISK = """
import sys, resource
import numpy as np
from fractions import Fraction
from pathlib import Path
from cosim.base.errors import RunError
from cosim.base.recording import Column, RecordGroup
from cosim.record.writer import Recorder

columns = int(sys.argv[2])
group = RecordGroup(name="control", period=1, columns=tuple(
    Column(name=f"c.x[{i}]", unit=None, is_float=False) for i in range(columns)))
recorder = Recorder(Path(sys.argv[1]), 60_000)
if sys.argv[3] == "limit":
    recorder.begin((group,), Fraction(1024))
    # The last column can take half of its rows; then the system refuses the write.
    resource.setrlimit(resource.RLIMIT_FSIZE, (60_000 * 8 * (columns + 1) - 30_000 * 8,) * 2)
try:
    if sys.argv[3] != "limit":
        recorder.begin((group,), Fraction(1024))
    for row in range(0, 60_000, 500):
        cells = recorder.buffer(0, 500)
        cells[:] = np.arange(row * columns, (row + 500) * columns).reshape(500, columns)
        recorder.commit(0, row, 500)
    recorder.close()
except RunError as error:
    try:
        recorder.close()
    except RunError:
        pass
    sys.exit(str(error))
"""


def fill(path: Path, how: str) -> str:
    """Record until the system refuses; returns what the user is told."""
    done = subprocess.run(
        [sys.executable, "-c", FILL_THE_DISK, str(path), str(COLUMNS), how],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    return done.stderr


def test_a_write_that_the_system_refuses_ends_the_run_with_a_sentence(tmp_path: Path) -> None:
    told = fill(tmp_path / "run.h5", "limit")
    assert "no space left for the record" in told
    assert len(told.strip().splitlines()) == 1
    assert check_prefix(tmp_path, at_least=20_000) <= 30_000


def test_a_full_disk_ends_the_run_with_a_sentence(tmp_path: Path) -> None:
    with small_disk(tmp_path, "3m"):
        told = fill(tmp_path / "run.h5", "full disk")
        assert "no space left for the record" in told
        assert check_prefix(tmp_path, at_least=5_000) < 20_000


def test_a_disk_that_is_full_from_the_start_is_one_sentence(tmp_path: Path) -> None:
    with small_disk(tmp_path, "16k"):
        told = fill(tmp_path / "run.h5", "full disk")
        assert "no space left for the record" in told
        assert len(told.strip().splitlines()) == 1


def test_a_folder_that_cannot_be_written_is_one_sentence(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "nowhere" / "run.h5", 1000)
    with pytest.raises(RunError, match="cannot be written"):
        recorder.begin((GROUP,), Fraction(1024))


def test_a_broken_recorder_ends_the_run_instead_of_hanging_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise ValueError("a slip")

    monkeypatch.setattr(writer, "write_cells", broken)
    recorder = Recorder(tmp_path / "run.h5", 1_000_000)
    recorder.begin((GROUP,), Fraction(1024))

    def record() -> None:
        for row in range(0, 1_000_000, 500):
            recorder.buffer(0, 500)
            recorder.commit(0, row, 500)

    with pytest.raises(RunError, match="a slip"):
        record()
    with pytest.raises(RunError, match="a slip"):
        recorder.close()
