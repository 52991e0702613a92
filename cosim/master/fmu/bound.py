"""What an instance of either version of FMI does alike: the same functions under another prefix."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping, Sequence
from ctypes import c_char_p, c_void_p
from typing import Any

from cosim.base.component import VariableType
from cosim.master.fmu.binding import (
    EVENT_FUNCTIONS,
    OK,
    Assignment,
    Beginnings,
    Library,
    texts,
    whole_or_real,
)
from cosim.master.fmu.state import Look, StateFunctions

Types = Mapping[VariableType, tuple[str, Any]]
"""How the accessors of a type are called, and what they pass."""


class Bound:
    """One instance behind its library; the classes of the two versions say what differs.

    ``prefix`` is ``fmi2`` or ``fmi3``. ``calling`` is told the name of each function before it is
    called.
    """

    def __init__(
        self,
        prefix: str,
        types: Types,
        state: StateFunctions,
        functions: Library,
        calling: Callable[[str], None],
    ) -> None:
        self.handle = 0
        self._prefix, self._types, self._state = prefix, types, state
        self._functions = functions
        self._calling = calling

    def choose_log_categories(self, categories: Sequence[str]) -> int:
        """Log these categories and no others."""
        if f"{self._prefix}SetDebugLogging" not in self._functions:
            return OK
        return self._call("SetDebugLogging", True, len(categories), texts(categories))

    def set_values(self, kind: VariableType, reference: int, values: Sequence[Any]) -> int:
        """Set a variable's elements.

        Raises:
            ValueError: a value does not fit the type.
        """
        return self._set(kind, [reference], values)

    def set_texts(
        self, kind: VariableType, references: Sequence[int], contents: Sequence[bytes]
    ) -> int:
        """Set all elements of String or Binary variables."""
        return self._set(kind, references, contents)

    def assignment(
        self, kind: VariableType, references: Sequence[int], values: Sequence[Any]
    ) -> Assignment:
        """Elements of variables of one type, ready to be set.

        Raises:
            ValueError: a value does not fit the type, or the type is Binary, of which more is said.
        """
        if kind not in self._types:
            raise ValueError(f"a {kind} is not set with its values alone")
        name, passed = self._types[kind]
        array = texts(values) if passed is c_char_p else whole_or_real(passed, values)
        return Assignment(f"{self._prefix}Set{name}", self.references(references), array)

    def address(self, function: str) -> int:
        """Where a function begins."""
        return self._functions.address(function)

    def beginnings(self) -> Beginnings:
        """What brings the instance before tick 0."""
        reset, set_up = f"{self._prefix}Reset", f"{self._prefix}SetupExperiment"
        return Beginnings(
            reset=self.address(reset) if reset in self._functions else 0,
            set_up=self.address(set_up) if set_up in self._functions else 0,
            enter=self.address(f"{self._prefix}EnterInitializationMode"),
            leave=self.address(f"{self._prefix}ExitInitializationMode"),
        )

    def get_texts(
        self, kind: VariableType, references: Sequence[int], count: int
    ) -> tuple[int, list[bytes | None]]:
        """The status, and the ``count`` elements of String variables, copied at once.

        ``None`` stands for NULL. After a status that is not well there are none.
        """
        name, _ = self._types[kind]
        array: Any = (c_char_p * count)()
        which = self.references(references)
        status = self._call(f"Get{name}", which, len(references), array, *self._size(array))
        return status, list(array) if self.is_well(status) else []

    @staticmethod
    def is_well(status: int) -> bool:
        """Whether what a call was to return is there: OK or a warning."""
        return status in {0, 1}

    @staticmethod
    def references(references: Sequence[int]) -> Any:
        """A C array of value references."""
        return (ctypes.c_uint32 * len(references))(*references)

    def exit_initialisation(self) -> int:
        """Leave initialisation mode."""
        return self._call("ExitInitializationMode")

    def save_state(self) -> tuple[int, bytes]:
        """The status, and the whole state as bytes."""
        return self._state.save(self._named)

    def load_state(self, content: bytes) -> int:
        """Restore what ``save_state`` returned."""
        return self._state.load(self._named, content)

    def look_at_state(self, at: Look) -> int:
        """Have the whole state as bytes in the place of the look before."""
        return self._state.look(self._named, at)

    def keep_state(self) -> tuple[int, c_void_p]:
        """The status, and the state as the FMU's own object."""
        return self._state.keep(self._named)

    def put_state(self, state: c_void_p) -> int:
        """Go back to a state that was kept."""
        return self._state.put(self._named, state)

    def drop_state(self, state: c_void_p) -> int:
        """Give a kept state back."""
        return self._state.drop(self._named, state)

    def missing_state_functions(self) -> list[str]:
        """What the library lacks to save and to load a state."""
        return self._state.missing(self._functions)

    def do_step_address(self) -> int:
        """Where the step function begins."""
        return self._functions.address(f"{self._prefix}DoStep")

    def accessor_address(self, kind: VariableType, *, is_set: bool) -> int:
        """Where the set or get function of a type begins."""
        verb = "Set" if is_set else "Get"
        return self._functions.address(f"{self._prefix}{verb}{self._types[kind][0]}")

    def missing_event_functions(self) -> list[str]:
        """What the library lacks for event mode."""
        names = [f"{self._prefix}{name}" for name in EVENT_FUNCTIONS]
        return [name for name in names if name not in self._functions]

    def event_addresses(self) -> list[int]:
        """Where the functions of event mode begin."""
        return [self._functions.address(f"{self._prefix}{name}") for name in EVENT_FUNCTIONS]

    def reset(self) -> int | None:
        """Go back to what ``instantiate`` made; ``None`` where the library cannot."""
        return self._call("Reset") if f"{self._prefix}Reset" in self._functions else None

    def terminate(self) -> int:
        """End the run."""
        return self._call("Terminate")

    def free(self) -> None:
        """Give the instance back."""
        self._call("FreeInstance")
        self.handle = 0

    def _set(self, kind: VariableType, references: Sequence[int], values: Sequence[Any]) -> int:
        ready = self.assignment(kind, references, values)
        function = ready.function.removeprefix(self._prefix)
        size = self._size(values)
        return self._call(function, ready.references, len(references), ready.values, *size)

    def _size(self, values: Sequence[Any]) -> tuple[int, ...]:
        """FMI 3 is told how many values there are; FMI 2 has scalars alone."""
        return (len(values),) if self._prefix == "fmi3" else ()

    def _call(self, function: str, *arguments: Any) -> Any:
        """Call a function of the standard, named without its prefix."""
        return self._named(f"{self._prefix}{function}", *arguments)

    def _named(self, name: str, *arguments: Any) -> Any:
        """Call a function of the standard by its whole name."""
        self._calling(name)
        return self._functions[name](self.handle, *arguments)
