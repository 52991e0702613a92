"""A home that cannot be written stops nothing; a wrong COHAPTIC_CACHE_DIR is one sentence."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.command import cohaptic


def run(tmp_path: Path, **changes: str | None) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"TMPDIR": str(tmp_path)} | changes
    return subprocess.run(
        [sys.executable, "-c", "from fmus.cache import cache_directory; print(cache_directory())"],
        env={name: value for name, value in environment.items() if value is not None},
        capture_output=True,
        text=True,
        check=False,
    )


@pytest.mark.parametrize("home", ["/proc/nowhere", "/dev/null"])
def test_an_unwritable_home_gives_a_temporary_folder_and_a_warning(
    tmp_path: Path, home: str
) -> None:
    done = run(tmp_path, HOME=home, COHAPTIC_CACHE_DIR=None, XDG_CACHE_HOME=None)
    assert done.returncode == 0
    assert done.stdout.strip() == str(tmp_path / f"cohaptic-{os.getuid()}")
    assert done.stderr.startswith(f"warning: {home}/.cache/cohaptic cannot be written (")
    assert done.stderr.count("\n") == 1
    assert "Set COHAPTIC_CACHE_DIR to a folder that lasts." in done.stderr


def test_an_empty_home_means_the_users_own(tmp_path: Path) -> None:
    done = run(tmp_path, HOME="", COHAPTIC_CACHE_DIR=None, XDG_CACHE_HOME=None)
    assert done.returncode == 0
    assert Path(done.stdout.strip()).is_absolute()


@pytest.mark.parametrize("chosen", ["", "relative/folder"])
def test_a_relative_folder_is_refused(tmp_path: Path, chosen: str) -> None:
    done = run(tmp_path, COHAPTIC_CACHE_DIR=chosen)
    assert done.returncode == 1
    assert f"COHAPTIC_CACHE_DIR is '{chosen}'; it has to be the absolute path" in done.stderr


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    done = run(tmp_path, COHAPTIC_CACHE_DIR="/proc/nowhere")
    assert "COHAPTIC_CACHE_DIR is '/proc/nowhere', which cannot be written: no such" in done.stderr


def test_a_command_says_it_in_one_sentence(tmp_path: Path) -> None:
    command = "import sys; sys.argv[0] = 'cohaptic'; from cosim.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", command, "run", "single_user", "--out", str(tmp_path / "run")],
        env=os.environ | {"COHAPTIC_CACHE_DIR": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == (
        "COHAPTIC_CACHE_DIR is ''; it has to be the absolute path of a folder for caches, or not "
        "be set.\n"
    )


def test_a_folder_where_nothing_may_be_executed_is_told(tmp_path: Path) -> None:
    """As ``docker run --tmpfs /tmp`` makes one."""
    folder = tmp_path / "noexec"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "noexec", "tmpfs", str(folder)]
    if subprocess.run(mount, capture_output=True, check=False).returncode != 0:
        pytest.skip("mounting needs root")
    try:
        done = cohaptic("run", "single_user", folder=tmp_path, COHAPTIC_CACHE_DIR=str(folder))
    finally:
        subprocess.run(["umount", str(folder)], check=True)
    assert done.returncode == 2
    assert "where nothing may be executed (noexec): COHAPTIC_CACHE_DIR names" in done.stderr
