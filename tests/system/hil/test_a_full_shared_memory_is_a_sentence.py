"""Where no memory is left that processes can share: what for, how much, what to do, and status 1.

A place of a few kilobytes is mounted over ``/dev/shm`` and the folder of temporary files, for the
command alone. Nothing is left there afterwards, and nobody dies of a page that could not be had.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cosim.base.errors import RunError
from cosim.base.system import room
from tests.support.fmus.foreign import foreign_fmu, scalar

ASIDE = ["unshare", "--user", "--map-root-user", "--mount"]


def can_mount() -> bool:
    if sys.platform != "linux" or shutil.which("unshare") is None:
        return False
    asked = [*ASIDE, "mount", "-t", "tmpfs", "none", "/dev/shm"]
    return subprocess.run(asked, capture_output=True, check=False).returncode == 0


needs_mount = pytest.mark.skipif(
    not can_mount(), reason="the system lets nobody mount something for themselves"
)


def in_little_room(
    folder: Path, kilobytes: int, place: str, *words: str
) -> tuple[subprocess.CompletedProcess[str], list[str]]:
    """What the command says with so much at ``place``, and what it leaves behind there."""
    script = (
        'mount -t tmpfs -o size="$1"k none "$2"; shift 2; "$@"; status=$?; '
        'for each in /dev/shm/cohaptic-*; do echo "left: $each" >&2; done; exit $status'
    )
    (folder / "temporary").mkdir(exist_ok=True)
    call = [*ASIDE, "env", f"TMPDIR={folder / 'temporary'}", "bash", "-O", "nullglob", "-c"]
    call += [script, "-", str(kilobytes), place]
    call += [sys.executable, "-c", "from cosim.cli import main; main()", *words]
    done = subprocess.run(
        call,
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    lines = done.stderr.splitlines()
    rings = [line for line in lines if line.startswith("left: ") and "processor" not in line]
    return done, rings


def scenario(folder: Path, keys: str = "") -> str:
    """An FMU of somebody else with a few hundred values, and its record."""
    variables = "".join(scalar(3, f"u{n}", n, causality="input", start="0") for n in range(1, 60))
    fmu = foreign_fmu(folder, 3, variables)
    (folder / "s.yaml").write_text(
        f"cohaptic: 1\nduration: 8\nbase_rate: 100\ncomponents:\n"
        f"  box: {{fmu: {fmu}, rate: 100{keys}}}\nrecord: [box.u1]\n"
    )
    return "s.yaml"


def is_told(done: subprocess.CompletedProcess[str], what: str, place: str) -> None:
    assert done.returncode == 1, (done.returncode, done.stderr)
    assert f"There is no room for {what} in {place}: it takes " in done.stderr
    assert "Traceback" not in done.stderr


@needs_mount
@pytest.mark.parametrize(
    ("kilobytes", "what"),
    [
        (4, "the rows of 100Hz on their way to the record"),
        (24, "the state of the loop and its devices"),
        (28, "what others are told of the run"),
    ],
)
def test_of_a_paced_run(tmp_path: Path, kilobytes: int, what: str) -> None:
    words = ("run", scenario(tmp_path), "--realtime", "--no-figure", "--out", "out")
    done, left = in_little_room(tmp_path, kilobytes, "/dev/shm", *words)
    is_told(done, what, "/dev/shm")
    assert "are free (No space left on device); free some ('cohaptic doctor'" in done.stderr
    assert left == []


@needs_mount
def test_of_a_run_that_is_watched(tmp_path: Path) -> None:
    words = ("run", scenario(tmp_path), "--live", "--no-figure", "--out", "out")
    done, left = in_little_room(tmp_path, 4, "/dev/shm", *words)
    is_told(done, "the rows of 100Hz on their way to the record", "/dev/shm")
    assert left == []


@needs_mount
def test_of_a_game(tmp_path: Path) -> None:
    words = ("play", "two_users_box", "--no-browser", "--out", "out")
    done, left = in_little_room(tmp_path, 4, "/dev/shm", *words)
    is_told(done, "the pointer of a page", "/dev/shm")
    assert left == []


@needs_mount
def test_of_an_isolated_fmu(tmp_path: Path) -> None:
    file = scenario(tmp_path, ", isolate: process")
    place = str(tmp_path / "temporary")
    words = ("run", file, "--no-figure", "--out", "out")
    done, _ = in_little_room(tmp_path, 16, place, *words)
    is_told(done, "the memory that an isolated FMU shares with its process", place)
    assert "or name another folder in TMPDIR" in done.stderr


@needs_mount
def test_of_a_sweep(tmp_path: Path) -> None:
    place = str(tmp_path / "temporary")
    words = ("sweep", scenario(tmp_path), "--seeds", "2", "--workers", "1", "--out", "out")
    done, _ = in_little_room(tmp_path, 16, place, *words, "--no-figure")
    is_told(done, "what a worker of a sweep is doing", place)


def test_every_page_is_had_before_it_is_mapped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the system has no call for that; a refusal names the size."""
    for _ in range(2):
        with room.nameless_shared_file(200_000, "a test") as file:
            status = room.os.fstat(file.fileno())
            assert status.st_size == 200_000
            assert status.st_blocks * 512 >= 200_000
        monkeypatch.delattr("os.posix_fallocate", raising=False)
    monkeypatch.setattr(room, "_take", refuse)
    with pytest.raises(RunError, match=r"no room for a test in .*: it takes 5 kB, and .* are free"):
        room.nameless_shared_file(5000, "a test")


def refuse(*_: object) -> None:
    raise OSError(28, "No space left on device")
