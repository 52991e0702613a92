"""A sweep's folder: one sweep at a time writes it, and what cannot be written is a sentence."""

from __future__ import annotations

import resource
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import pytest

from cosim.base.errors import InputError, RunError
from cosim.sweep.job import RunResult
from cosim.sweep.results.store import RESULTS_FILE, ResultStore


def result(number: int) -> RunResult:
    return RunResult(number, f"key {number}", (number,), "good", measures={"drift": float("nan")})


def add_all(store: ResultStore, count: int) -> None:
    for number in range(count):
        store.add(result(number))


@contextmanager
def room_for(most: int) -> Generator[None]:
    """Files of this process can have so many bytes, as on a disk that is full then."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


def test_a_second_sweep_waits_or_goes_elsewhere(tmp_path: Path) -> None:
    """Else each of them runs what the other has run."""
    out = tmp_path / "out"
    with ResultStore(out) as store:
        store.describe({})
        store.add(result(1))
        with pytest.raises(InputError, match=r"another sweep is at work in .*out; wait for it"):
            ResultStore(out)
        store.add(result(2))
    with ResultStore(out) as again:
        assert len(again.known) == 2


def test_a_folder_that_was_refused_is_let_go_of(tmp_path: Path) -> None:
    with ResultStore(tmp_path / "out") as store:
        store.describe({})
    (tmp_path / "out" / RESULTS_FILE).write_text("spoiled\n")
    for _ in range(2):
        with pytest.raises(InputError, match="this is no result"):
            ResultStore(tmp_path / "out")


def test_a_full_disk_is_a_sentence_and_what_was_whole_is_kept(tmp_path: Path) -> None:
    out = tmp_path / "out"
    with room_for(1000), ResultStore(out) as store:
        store.describe({})
        with pytest.raises(RunError, match=r"results\.jsonl cannot be written: .*goes on"):
            add_all(store, 100)
        assert set(store.known) == {f"key {n}" for n in range(len(store.known))}
        kept = len(store.known)
    with ResultStore(out) as again:
        assert 0 < len(again.known) == kept
        again.add(result(kept))
    with ResultStore(out) as whole:
        assert len(whole.known) == kept + 1


def test_a_description_that_cannot_be_written_leaves_no_half(tmp_path: Path) -> None:
    out = tmp_path / "out"
    sentence = r"sweep\.json cannot be written"
    with room_for(10), ResultStore(out) as store, pytest.raises(InputError, match=sentence):
        store.describe({"points": [0] * 100})
    assert list(out.iterdir()) == []
