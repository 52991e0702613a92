"""Texts and binary values of a run: their changes, beside the rows of numbers.

While the run goes on they are appended to ``run.texts``: a line of JSON that names the columns, and
for each change its group, column, tick and length (little-endian) before the bytes. A process that
dies leaves what it has appended. At the end they become ``texts.h5``, put in place in one step::

    /<group>/<n>         one for each text, in the order recorded; attributes: name, type (String or
                         Binary), causality, description
    /<group>/<n>/tick    int64 (changes,): the base tick since which it is so
    /<group>/<n>/value   variable length (changes,): texts, or bytes

A run in which no text is recorded has neither file.
"""

from __future__ import annotations

import json
import struct
from bisect import bisect_right
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import RecordGroup, TextColumn
from cosim.record.hdf5 import h5py

JOURNAL_FILE, TEXTS_FILE = "run.texts", "texts.h5"
_CHANGE = struct.Struct("<iiqq")


@dataclass(frozen=True, slots=True)
class RecordedText:
    """One recorded String or Binary: what it was, and since when."""

    column: TextColumn
    changes: tuple[tuple[int, bytes], ...]
    """The base tick of each change, the first one recorded among them, and what it was then."""

    @property
    def name(self) -> str:
        """Component and variable."""
        return self.column.name

    @property
    def ticks(self) -> NDArray[np.int64]:
        """The base ticks of the changes, shape (changes,)."""
        return np.array([tick for tick, _ in self.changes], dtype=np.int64)

    @property
    def values(self) -> list[Any]:
        """What it was since each of ``ticks``: ``str``, or ``bytes`` of a Binary."""
        return [self._shown(content) for _, content in self.changes]

    def at(self, tick: int) -> Any:
        """What it was at a base tick; ``None`` before the first one recorded."""
        found = bisect_right(self.changes, tick, key=lambda change: change[0])
        return self._shown(self.changes[found - 1][1]) if found else None

    def before(self, tick: int) -> RecordedText:
        """The same without what was not before a tick."""
        return RecordedText(self.column, tuple(c for c in self.changes if c[0] < tick))

    def _shown(self, content: bytes) -> Any:
        return content if self.column.is_binary else content.decode()


Texts = Mapping[str, Sequence[RecordedText]]
"""The recorded texts of each group."""


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
        return _read_file(folder / TEXTS_FILE)
    journal = folder / JOURNAL_FILE
    return _read_journal(journal) if journal.is_file() else {}


def write_texts(path: Path, texts: Texts) -> None:
    """Write the file whole, or not at all.

    Raises:
        OSError: it cannot be written.
    """
    size = sum(
        len(content) + 64
        for found in texts.values()
        for text in found
        for _, content in text.changes
    )
    scratch = path.with_suffix(".part")
    try:
        with scratch.open("wb") as room:  # HDF5 ends the process where it cannot write on closing
            room.write(bytes(size + (1 << 16)))
        with h5py().File(scratch, "w") as file:
            for name, found in texts.items():
                node = file.create_group(name)
                for number, text in enumerate(found):
                    _write_text(node.create_group(str(number)), text)
        scratch.replace(path)
    finally:
        scratch.unlink(missing_ok=True)


def _write_text(node: Any, text: RecordedText) -> None:
    column = text.column
    kind = h5py().vlen_dtype(np.uint8) if column.is_binary else h5py().string_dtype()
    node.attrs["name"], node.attrs["causality"] = column.name, column.causality
    node.attrs["description"] = column.description
    node.attrs["type"] = "Binary" if column.is_binary else "String"
    node["tick"] = text.ticks
    values = node.create_dataset("value", (len(text.changes),), dtype=kind)
    for place, (_, content) in enumerate(text.changes):
        values[place] = np.frombuffer(content, np.uint8) if column.is_binary else content


def _read_file(path: Path) -> Texts:
    with h5py().File(path, "r", locking=False) as file:
        return {
            name: [_read_text(node[str(number)]) for number in range(len(node))]
            for name, node in file.items()
        }


def _read_text(node: Any) -> RecordedText:
    attributes = node.attrs
    column = TextColumn(
        name=str(attributes["name"]),
        is_binary=str(attributes["type"]) == "Binary",
        description=str(attributes["description"]),
        causality=str(attributes["causality"]),
    )
    contents: Iterable[Any] = node["value"][()]
    return RecordedText(
        column, tuple(zip(node["tick"][()].tolist(), map(_plain, contents), strict=True))
    )


def _plain(content: Any) -> bytes:
    return content if isinstance(content, bytes) else content.tobytes()


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
