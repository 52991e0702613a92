"""Texts and binary values of a run: their changes, beside the rows of numbers.

At the end of a run they become ``texts.h5``, put in place in one step::

    /<group>/<n>         one for each text, in the order recorded; attributes: name, type (String or
                         Binary), causality, description
    /<group>/<n>/tick    int64 (changes,): the base tick since which it is so
    /<group>/<n>/value   variable length (changes,): texts, or bytes

A run in which no text is recorded has no such file.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import TextColumn
from cosim.record.hdf5 import h5py

TEXTS_FILE = "texts.h5"


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


def read_text_file(path: Path) -> Texts:
    """What ``write_texts`` wrote.

    Raises:
        OSError: it cannot be read.
    """
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
