"""What an FMU declares of its state: which bytes of a saved one are numbers that may be moved."""

from __future__ import annotations

import json
import math
import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.master.fmu.description import FmuDescription
from fmus.state import STATE_FILE

Words = NDArray[np.int64]
"""A saved state as words of eight bytes, shape (n,)."""

CHECKSUM, CHECKED = 5, 6
"""The word that holds the checksum, and the first that it covers (fmus/fmi/snapshot.c)."""
_DIGEST = slice(2, 4)
_CONDITION = re.compile(r"(?P<name>[\w.]+)(?:(?P<sign>>=|==)(?P<value>\d+))?")


@dataclass(frozen=True, slots=True)
class LiveReal:
    """A number that what follows depends on: its C path, unit and the step it may be moved by."""

    path: str
    unit: str
    step: float


@dataclass(frozen=True, slots=True)
class _Ring:
    first: int
    index: int
    width: int
    length: int
    live: int
    backwards: bool

    def places(self, words: Words) -> list[int]:
        """The words of the live rows, the newest first."""
        newest = int(words[self.index])
        turn = -1 if self.backwards else 1
        rows = [(newest + turn * age) % self.length for age in range(self.live)]
        return [
            self.first + self.width * row + column for row in rows for column in range(self.width)
        ]


class DeclaredState:
    """One FMU's saved state: where its live numbers are, and what each of its words is.

    Args:
        description: of the FMU.
        words: a saved state; the parameters in it say what is live.

    Raises:
        LookupError: the FMU ships no table, or one of another build.
    """

    def __init__(self, description: FmuDescription, words: Words) -> None:
        self._description = description
        self._table = _read_table(description, words)
        self.begin = int(self._table["cells_offset"]) // 8
        self.first = self.begin + int(self._table["slots"])
        """The word at which the model's State begins."""
        self.is_linear = bool(self._table["linear"])
        self.live: list[LiveReal] = []
        self.names: dict[int, str] = {}
        """The C path of every word that may change, by its place."""
        self.numbers: set[int] = set()
        """The words that are numbers, live or not."""
        self.modes: list[int] = []
        """The words that a run at rest keeps."""
        self._static: list[int] = []
        self._rings: list[_Ring] = []
        self._place(words)

    def places(self, words: Words) -> NDArray[np.int64]:
        """The words of the live numbers, in the order of ``live``; rings are read by age."""
        found = list(self._static)
        for ring in self._rings:
            found += ring.places(words)
        return np.array(found, dtype=np.int64)

    def value(self, words: Words, variable: str) -> float:
        """A variable, as it is saved with the state.

        Raises:
            KeyError: there is none of that name.
        """
        place = self.begin + self._description.references[variable]
        is_float = self._description.variables[variable].type.is_float
        return float(words.view(np.float64)[place] if is_float else words[place])

    def elements(self, words: Words, variable: str) -> dict[str, float]:
        """A variable of any shape, as it is saved with the state: a number an element."""
        described = self._description.variables[variable]
        first = self.begin + self._description.references[variable]
        saved = words.view(np.float64) if described.type.is_float else words
        if not described.shape:
            return {variable: float(saved[first])}
        count = math.prod(described.shape)
        return {f"{variable}[{n + 1}]": float(saved[first + n]) for n in range(count)}

    @property
    def changing(self) -> NDArray[np.int64]:
        """The words of the State that may change after initialisation."""
        return np.array(sorted(self.numbers | self.names.keys()), dtype=np.int64)

    def _place(self, words: Words) -> None:
        for path, offset, unit, step, when in self._table["reals"]:
            place = self._word(path, offset)
            self.numbers.add(place)
            if self._holds(words, when):
                self.live.append(LiveReal(path, unit, step))
                self._static.append(place)
        for path, offset, is_mode in self._table["words"]:
            place = self._word(path, offset)
            if is_mode:
                self.modes.append(place)
        for ring in self._table["rings"]:
            self._place_ring(words, ring)

    def _place_ring(self, words: Words, ring: dict[str, Any]) -> None:
        width, first = int(ring["width"]), self.first + int(ring["offset"]) // 8
        for place in range(first, first + width * int(ring["rows"])):
            self.names[place] = f"{ring['path']}[{(place - first) // width}]"
            self.numbers.add(place)
        length, live = (self._size(words, ring[name]) for name in ("length", "live"))
        if not self._holds(words, ring["when"]) or length == 0:
            return
        self._rings.append(
            _Ring(
                first,
                self.first + int(ring["index"]) // 8,
                width,
                length,
                live,
                bool(ring["backwards"]),
            )
        )
        self.live += [
            LiveReal(f"{ring['path']} of age {age + 1}[{column}]", ring["unit"], ring["step"])
            for age in range(live)
            for column in range(width)
        ]

    def _word(self, path: str, offset: int) -> int:
        place = self.first + offset // 8
        self.names[place] = path
        return place

    def _size(self, words: Words, value: int | str) -> int:
        return value if isinstance(value, int) else int(self.value(words, value))

    def _holds(self, words: Words, when: str) -> bool:
        return all(self._compares(words, part) for part in when.split("&") if part)

    def _compares(self, words: Words, condition: str) -> bool:
        found = _CONDITION.fullmatch(condition)
        assert found is not None, condition
        value = self.value(words, found["name"])
        if found["sign"] is None:
            return value != 0.0
        wanted = int(found["value"])
        return value >= wanted if found["sign"] == ">=" else value == wanted


def _read_table(description: FmuDescription, words: Words) -> dict[str, Any]:
    file = description.folder / STATE_FILE
    if not file.is_file():
        raise LookupError("it does not declare its state")
    table: dict[str, Any] = json.loads(file.read_text())
    digest = [int(table["digest"][:16], 16), int(table["digest"][16:], 16)]
    if words[_DIGEST].view(np.uint64).tolist() != digest:
        raise LookupError("the table of its state is another build's")
    return table
