"""The folder of an unpacked FMU is there with its note or not at all, whoever else is at it."""

from __future__ import annotations

import os
import threading
import time
from pathlib import Path

import pytest

import fmus
from cosim.master.fmu import archive
from cosim.master.fmu.archive import sha256_of, unpack


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr("fmus.cache.cache_directory", lambda: tmp_path)
    return tmp_path


FMU = fmus.find("hand", "fmi3")


def test_one_that_was_changed_is_unpacked_anew() -> None:
    digest = sha256_of(FMU)
    folder = unpack(FMU, digest)
    held = os.open(folder, os.O_RDONLY)  # so that its number is given to no other folder
    before = folder.stat().st_ino
    assert unpack(FMU, digest).stat().st_ino == before
    (folder / "left").touch()
    assert unpack(FMU, digest).stat().st_ino != before
    assert not (folder / "left").exists()
    os.close(held)


def test_who_is_stopped_in_the_middle_leaves_nothing(
    own_cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody else may find a folder of which nothing is known."""

    def stopped(file: Path, content: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(archive, "_keep", stopped)
    with pytest.raises(KeyboardInterrupt):
        unpack(FMU, sha256_of(FMU))
    assert not list(own_cache.rglob("modelDescription.xml"))


def test_processes_that_unpack_it_at_once_have_all_of_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """What one of them was handed, no other one takes away."""
    digest = sha256_of(FMU)
    plain = archive._keep

    def slowly(file: Path, content: object) -> None:
        time.sleep(0.02)
        plain(file, content)

    monkeypatch.setattr(archive, "_keep", slowly)
    begin, lost = threading.Barrier(6), []

    def at_once() -> None:
        begin.wait()
        folder = unpack(FMU, digest)
        for _ in range(10):
            if not os.path.isdir(folder / "binaries"):  # noqa: PTH112 - as it is at this moment
                lost.append(folder)
            time.sleep(0.005)

    threads = [threading.Thread(target=at_once) for _ in range(6)]
    for each in threads:
        each.start()
    for each in threads:
        each.join()
    assert lost == []
