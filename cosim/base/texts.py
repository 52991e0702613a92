"""Texts and binary values of a run: cells carry their numbers, a table has their bytes.

A cell has eight bytes, so a String or Binary element lives in it as the number of its value.
Sampling, holding, delays and losses then treat it like any other cell. Number 0 is the empty value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

MOST_BYTES = 16 << 20
"""The longest value."""
MOST_LIVE_BYTES = 256 << 20
"""Of all different values that a run holds at one time."""
_SWEEP_COUNT, _SWEEP_BYTES = 4096, 16 << 20


class TextTable:
    """The values by number; those that no cell names any more are dropped now and then.

    ``named`` tells which numbers are still in cells and packets.
    """

    def __init__(self, named: Callable[[], Iterable[int]]) -> None:
        self._named = named
        self.clear()

    def clear(self) -> None:
        """Hold the empty value alone, as before a run."""
        self._contents: dict[int, bytes] = {0: b""}
        self._numbers: dict[bytes, int] = {b"": 0}
        self._next = 1
        self._size = 0
        self._sweep_at = (_SWEEP_COUNT, _SWEEP_BYTES)

    def number(self, content: bytes) -> int:
        """The number of a value; it is entered where it is new.

        Raises:
            ValueError: it is too long, or the run holds too much.
        """
        known = self._numbers.get(content)
        if known is not None:
            return known
        if len(content) > MOST_BYTES:
            raise ValueError(
                f"a text or binary value of {len(content)} bytes is longer than the {MOST_BYTES} "
                "bytes that are carried"
            )
        if len(self._contents) >= self._sweep_at[0] or self._size >= self._sweep_at[1]:
            self._sweep()
        if self._size + len(content) > MOST_LIVE_BYTES:
            raise ValueError(
                f"the texts and binary values of the run's variables and packets hold more than "
                f"{MOST_LIVE_BYTES} bytes together"
            )
        number, self._next = self._next, self._next + 1
        self._contents[number], self._numbers[content] = content, number
        self._size += len(content)
        return number

    def content(self, number: int) -> bytes:
        """The value of a number that a cell has."""
        return self._contents[number]

    def save(self) -> dict[int, bytes]:
        """Every value that a cell or a packet names, by number."""
        self._sweep()
        return dict(self._contents)

    def load(self, contents: Mapping[int, bytes]) -> None:
        """Hold what ``save`` returned, and no more."""
        self.clear()
        self._contents.update(contents)
        self._numbers.update((content, number) for number, content in contents.items())
        self._next = max(self._contents) + 1
        self._size = sum(map(len, self._contents.values()))

    def _sweep(self) -> None:
        live = {0, *self._named()}
        self._contents = {n: content for n, content in self._contents.items() if n in live}
        self._numbers = {content: n for n, content in self._contents.items()}
        self._size = sum(map(len, self._contents.values()))
        self._sweep_at = (
            max(_SWEEP_COUNT, 2 * len(self._contents)),
            max(_SWEEP_BYTES, 2 * self._size),
        )


class TextCells:
    """The elements of one String (``str``) or Binary (``bytes``) variable of a Python component.

    Indexed as an array of the variable's shape, ``(1,)`` for a scalar: ``label[0] = "ready"``.
    """

    def __init__(self, cells: NDArray[np.int64], table: TextTable, *, is_binary: bool) -> None:
        self._cells, self._table, self.is_binary = cells, table, is_binary

    @property
    def shape(self) -> tuple[int, ...]:
        """That of the variable; ``(1,)`` for a scalar."""
        return self._cells.shape

    def __getitem__(self, index: int | tuple[int, ...]) -> Any:
        """One element: a ``str``, or ``bytes`` of a Binary."""
        content = self._table.content(int(self._cells[index]))
        return content if self.is_binary else content.decode()

    def __setitem__(self, index: int | tuple[int, ...], value: str | bytes) -> None:
        """Put an element out.

        Raises:
            TypeError: it is of the other type.
            ValueError: it cannot be carried, or is longer than ``MOST_BYTES``.
        """
        self._cells[index] = self._table.number(encoded(value, is_binary=self.is_binary))


def encoded(value: Any, *, is_binary: bool) -> bytes:
    """A value as bytes.

    Raises:
        TypeError: it is of the other type.
        ValueError: a String with NUL in it, where C ends a text, or with half a character.
    """
    if is_binary:
        if not isinstance(value, bytes | bytearray):
            raise TypeError(f"a Binary takes bytes, not {type(value).__name__}")
        return bytes(value)
    if not isinstance(value, str):
        raise TypeError(f"a String takes str, not {type(value).__name__}")
    if "\0" in value:
        raise ValueError("a String cannot have the character NUL in it; a Binary can")
    return value.encode()
