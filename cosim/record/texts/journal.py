"""The changes of texts on their way to a run's folder, from which a reader takes them at any time.

``run.texts``: a line of JSON that names the columns, and for each change its group, column, tick
and length (little-endian) before the bytes. A process that dies leaves what it has appended.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from cosim.base.recording import RecordGroup, TextColumn
from cosim.record.texts.recorded import (
    TEXTS_FILE,
    RecordedText,
    Texts,
    read_text_file,
    write_texts,
)

JOURNAL_FILE = "run.texts"
_CHANGE = struct.Struct("<iiqq")


class TextJournal:
    """Appends changes to a run's folder, each in one write; ``finish`` makes the file to keep."""

    def __init__(self, folder: Path, groups: Sequence[RecordGroup]) -> None:
        """Begin ``run.texts``.

        Raises:
            OSError: it cannot be written.
        """
        self._folder = folder
        self._last: dict[tuple[int, int], bytes] = {}
        self._file = (folder / JOURNAL_FILE).open("wb", buffering=0)
        head = [[group.name, [asdict(text) for text in group.texts]] for group in groups]
        self._write(json.dumps(head).encode() + b"\n")

    def put(self, group: int, column: int, tick: int, content: bytes) -> None:
        """A text as it is from a tick on; nothing where it stays as it was.

        Raises:
            OSError: it cannot be written.
        """
        if self._last.get((group, column)) == content:
            return
        self._last[group, column] = content
        self._write(_CHANGE.pack(group, column, tick, len(content)) + content)

    def finish(self) -> None:
        """Write ``texts.h5`` of everything that was put, and take the journal away.

        Raises:
            OSError: it cannot be written; the journal is still there.
        """
        self._file.close()
        write_texts(self._folder / TEXTS_FILE, _read_journal(self._folder / JOURNAL_FILE))
        (self._folder / JOURNAL_FILE).unlink()

    def close(self) -> None:
        """Leave the journal as it is."""
        self._file.close()

    def _write(self, data: bytes) -> None:
        view = memoryview(data)
        while view:
            view = view[self._file.write(view) :]


def read_texts(folder: Path) -> Texts:
    """What a run's folder has of texts; of one that was cut off, what its journal has.

    Raises:
        OSError: a file cannot be read.
    """
    if (folder / TEXTS_FILE).is_file():
        return read_text_file(folder / TEXTS_FILE)
    journal = folder / JOURNAL_FILE
    return _read_journal(journal) if journal.is_file() else {}


def _read_journal(path: Path) -> Texts:
    head, _, data = path.read_bytes().partition(b"\n")
    groups: list[Any] = json.loads(head) if head.endswith(b"]") else []
    names = [name for name, _ in groups]
    columns = [[TextColumn(**column) for column in described] for _, described in groups]
    found: list[list[list[tuple[int, bytes]]]] = [[[] for _ in each] for each in columns]
    for group, column, tick, content in _changes(data):
        found[group][column].append((tick, content))
    return {
        name: [RecordedText(c, tuple(f)) for c, f in zip(described, changes, strict=True)]
        for name, described, changes in zip(names, columns, found, strict=True)
    }


def _changes(data: bytes) -> Iterator[tuple[int, int, int, bytes]]:
    """What was appended whole."""
    at = 0
    while at + _CHANGE.size <= len(data):
        group, column, tick, size = _CHANGE.unpack_from(data, at)
        begin, at = at + _CHANGE.size, at + _CHANGE.size + size
        if at > len(data):
            return
        yield group, column, tick, data[begin:at]
