"""An FMU that was found to be of its sources is trusted until one of the files changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from cosim.base.errors import InputError
from fmus import builder, find, fresh


class _Tree:
    """A folder of sources, and how often the model's are digested."""

    def __init__(self, folder: Path) -> None:
        self.file = folder / "shared" / "room" / "part.c"
        self.file.parent.mkdir(parents=True)
        self.file.write_text("int a;")
        self.digested = 0

    def digest(self, source: builder.Source) -> object:
        self.digested += 1
        note = builder.read_note(source.model.name)
        assert note is not None
        return note["digest"]


@pytest.fixture(name="tree")
def _tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> _Tree:
    monkeypatch.setenv("COHAPTIC_CACHE_DIR", str(tmp_path / "cache"))
    tree = _Tree(tmp_path / "sources")
    monkeypatch.setattr(fresh, "FOLDER", tmp_path / "sources")
    monkeypatch.setattr(fresh, "SETTLED", 0.0)
    monkeypatch.setattr(builder, "source_digest", tree.digest)
    return tree


def test_it_is_digested_once_for_all_processes(tree: _Tree) -> None:
    for _ in range(3):
        find("hand")
    assert tree.digested == 1


@pytest.mark.parametrize("text", ["int b;", "int longer;"])
def test_it_is_digested_again_after_a_change(tree: _Tree, text: str) -> None:
    find("hand")
    tree.file.write_text(text)
    find("hand")
    assert tree.digested == 2


def test_a_file_that_appears_or_goes_is_a_change(tree: _Tree) -> None:
    find("hand")
    other = tree.file.with_name("other.h")
    other.write_text("")
    find("hand")
    other.unlink()
    find("hand")
    assert tree.digested == 3


def test_nothing_is_remembered_of_a_file_that_has_just_been_written(
    tree: _Tree, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fresh, "SETTLED", 60.0)
    find("hand")
    find("hand")
    assert tree.digested == 2


def test_what_is_stale_is_refused_each_time(tree: _Tree, monkeypatch: pytest.MonkeyPatch) -> None:
    find("hand")
    monkeypatch.setattr(builder, "source_digest", lambda _: "0" * 64)
    tree.file.write_text("int c;")
    for _ in range(2):
        with pytest.raises(InputError, match="older than its sources"):
            find("hand")
