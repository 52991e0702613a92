"""One FMU of a run: its saved state at the start of the hyperperiod, with numbers put in place."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.declared import CHECKED, CHECKSUM, DeclaredState, Words
from cosim.base.component import Causality
from cosim.master.fmu.instance import Fmu
from cosim.master.kernel.native import library

Real = NDArray[np.float64]


class SavedFmu:
    """An FMU that can be put back into one state, or into one that differs in its numbers."""

    def __init__(self, fmu: Fmu) -> None:
        self.fmu = fmu
        self.words = _words(fmu.states.save())
        self.declared = DeclaredState(fmu.description, self.words)
        self.start = self.declared.places(self.words)
        self._timed: dict[frozenset[str], list[str]] = {}
        self._values = self.words.view(np.float64)[self.start]
        self.end: NDArray[np.int64] = self.start
        """The words of the live numbers after the hyperperiod, and all words then."""
        self.after = self.words
        changing = np.ones(self.words.size, dtype=np.bool_)
        changing[: self.declared.first] = False
        changing[sorted(self.declared.numbers)] = False
        self._fixed = np.flatnonzero(changing)
        self._fixed_after = self.words[self._fixed]

    @property
    def values(self) -> Real:
        """The live numbers at the start, shape (n,)."""
        return self._values

    def restart(self) -> None:
        """Take the state that the FMU has now as the one to start from."""
        self.words = _words(self.fmu.states.save())
        self.start = self.declared.places(self.words)
        self._values = self.words.view(np.float64)[self.start]
        self.fmu.states.keep(keeper=self)

    def put(self, values: Real) -> None:
        """Be at the start with these live numbers."""
        if self.fmu.states.keeper is self and bool((values == self._values).all()):
            self.fmu.states.go_back()
            return
        words = self.words.copy()
        words.view(np.float64)[self.start] = values
        words[CHECKSUM] = _checksum(words)
        self.fmu.states.load(words.tobytes())

    def overwrite(self, values: Mapping[str, float]) -> None:
        """Give variables other values now, whatever they are: parameters too."""
        words = _words(self.fmu.states.save()).copy()
        for variable, value in values.items():
            place = self.declared.begin + self.fmu.description.references[variable]
            if self.fmu.description.variables[variable].type.is_float:
                words.view(np.float64)[place] = value
            else:
                words[place] = int(value)
        words[CHECKSUM] = _checksum(words)
        self.fmu.states.load(words.tobytes())

    def adopt(self, other: SavedFmu) -> None:
        """Stand where another instance of the model does, which has other parameters."""
        words, changing = self.words.copy(), self.declared.changing
        words[CHECKED : self.declared.begin] = other.words[CHECKED : self.declared.begin]
        words[changing] = other.words[changing]
        words[CHECKSUM] = _checksum(words)
        self.fmu.states.load(words.tobytes())

    def note_end(self) -> Real:
        """Take the state now as the one that the undisturbed run ends in; its live numbers."""
        self.after = _words(self.fmu.states.look()).copy()
        self._fixed_after = self.after[self._fixed]
        self.end = self.declared.places(self.after)
        return self.after.view(np.float64)[self.end]

    def word(self, path: str) -> int:
        """A mode or count at the start by its C path; 0 where there is none of that name."""
        for place, name in self.declared.names.items():
            if name == path:
                return int(self.words[place])
        return 0

    def changed_mode(self) -> str | None:
        """The first mode that the undisturbed run changed, by name."""
        for place in self.declared.modes:
            if self.words[place] != self.after[place]:
                return self.declared.names[place]
        return None

    def timed_outputs(self, moved: Collection[str]) -> dict[str, float]:
        """The outputs now that depend on none of the ``moved`` inputs, by element."""
        key = frozenset(moved)
        if key not in self._timed:
            description = self.fmu.description
            self._timed[key] = [
                name
                for name, variable in description.variables.items()
                if variable.causality is Causality.OUTPUT
                and key.isdisjoint(
                    one.partition("[")[0] for one in description.dependencies.get(name, ())
                )
            ]
        words, found = _words(self.fmu.states.look()), dict[str, float]()
        for name in self._timed[key]:
            found |= self.declared.elements(words, name)
        return found

    def read(self) -> tuple[Real, str | None]:
        """The live numbers at the end, and the first word that is not as undisturbed, by name."""
        words = _words(self.fmu.states.look())
        other = words[self._fixed] != self._fixed_after
        differs = None
        if other.any():
            place = int(self._fixed[np.argmax(other)])
            differs = self.declared.names.get(place, f"byte {8 * place} of its state")
        return words.view(np.float64)[self.end], differs


def _words(content: Any) -> Words:
    if len(content) % 8:
        raise LookupError(f"its state of {len(content)} bytes is not the state of a bundled model")
    return np.frombuffer(content, dtype=np.int64)


def _checksum(words: Words) -> int:
    checked = np.ascontiguousarray(words[CHECKED:])
    found = int(library().kernel_checksum(checked.ctypes.data, checked.size))
    return found - (1 << 64) if found >= 1 << 63 else found
