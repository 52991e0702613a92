"""Processes share what is unpacked: nobody takes a folder away that another one has just filled."""

from __future__ import annotations

import threading
import zipfile
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.base.system import store
from cosim.master.fmu import archive
from cosim.master.fmu.archive import sha256_of, unpack


@pytest.fixture(name="fmu")
def _fmu(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("COHAPTIC_CACHE_DIR", str(tmp_path / "cache"))
    path = tmp_path / "part.fmu"
    with zipfile.ZipFile(path, "w") as content:
        content.writestr("modelDescription.xml", "<fmiModelDescription/>")
        content.writestr("binaries/x86_64-linux/part.so", "library")
    return path


def test_who_comes_while_it_is_unpacked_waits_and_takes_the_same(
    fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    reached, go_on = threading.Event(), threading.Event()
    filled: list[Path] = []
    fill = archive._fill

    def slow(home: Path, path: Path) -> None:
        filled.append(home)
        reached.set()
        go_on.wait(10)
        fill(home, path)

    monkeypatch.setattr(archive, "_fill", slow)
    found: list[Path] = []
    threads = [
        threading.Thread(target=lambda: found.append(unpack(fmu, sha256_of(fmu)))) for _ in range(2)
    ]
    threads[0].start()
    assert reached.wait(10)
    threads[1].start()
    threads[1].join(0.3)
    go_on.set()
    for thread in threads:
        thread.join(10)
    assert found[0] == found[1]
    assert len(filled) == 1, "the second takes what the first has unpacked"
    assert (found[0] / "binaries/x86_64-linux/part.so").read_text() == "library"


def test_another_python_takes_the_same(fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What one version keeps for itself, another cannot read."""
    inode = unpack(fmu, sha256_of(fmu)).stat().st_ino
    monkeypatch.setattr(store, "_MAGIC", b"cohaptic store 1 another-python 9\n")
    assert unpack(fmu, sha256_of(fmu)).stat().st_ino == inode


def test_where_nothing_can_be_kept_there_is_a_sentence(
    fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(InputError, match=r"part\.fmu could not be unpacked .*No space left"):
        unpack(fmu, sha256_of(fmu))
