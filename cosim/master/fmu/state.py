"""An FMU's whole state as bytes, where it offers that: saved, serialised, restored, freed.

FMI 2.0.4 section 2.1.8, FMI 3.0 section 2.2.6; the functions of both differ in their names alone.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_int, c_size_t, c_void_p
from dataclasses import dataclass
from typing import Any, Protocol

from cosim.master.fmu.binding import FATAL, OK, WARNING, Library, Prototype

MOST_BYTES = 1 << 32
"""That a state may have; what is larger is a number that was never set."""


class StateError(ValueError):
    """A call about a state was said to be well, and what it gave cannot be used."""


@dataclass(slots=True)
class Look:
    """A state of the FMU's own that each look at it overwrites, and its bytes."""

    state: c_void_p
    content: Any = b""


class CallByName(Protocol):
    """Calls a function of an instance by its name in the standard, and returns its status."""

    def __call__(self, name: str, *arguments: Any) -> int:
        """``arguments`` are those after the instance."""
        ...


@dataclass(frozen=True, slots=True)
class StateFunctions:
    """The names of the functions in one version of the standard."""

    get: str
    set: str
    free: str
    size: str
    serialise: str
    deserialise: str
    byte: Any

    def prototypes(self) -> dict[str, Prototype]:
        """What each function is given; an FMU need not have any of them."""
        return {
            self.get: (c_int, (c_void_p, POINTER(c_void_p))),
            self.set: (c_int, (c_void_p, c_void_p)),
            self.free: (c_int, (c_void_p, POINTER(c_void_p))),
            self.size: (c_int, (c_void_p, c_void_p, POINTER(c_size_t))),
            self.serialise: (c_int, (c_void_p, c_void_p, POINTER(self.byte), c_size_t)),
            self.deserialise: (c_int, (c_void_p, POINTER(self.byte), c_size_t, POINTER(c_void_p))),
        }

    def missing(self, library: Library) -> list[str]:
        """Those that the library lacks."""
        return [name for name in self.prototypes() if name not in library]

    def save(self, call: CallByName) -> tuple[int, bytes]:
        """The first status that is neither OK nor a warning, and the serialised state.

        Raises:
            StateError: no state was handed out, or its size cannot be.
        """
        status, state = self.keep(call)
        if status not in {OK, WARNING}:
            return status, b""
        size, content = c_size_t(), b""
        status = call(self.size, state, ctypes.byref(size))
        if status in {OK, WARNING}:
            try:
                room = self._room(size.value)
            except StateError:
                self._freed(call, state, status)
                raise
            status = call(self.serialise, state, room, size.value)
            content = bytes(room)
        return self._freed(call, state, status), content

    def look(self, call: CallByName, at: Look) -> int:
        """Serialise the state into what was looked at before; ``drop`` gives its object back.

        Raises:
            StateError: no state was handed out, or its size cannot be.
        """
        status = call(self.get, ctypes.byref(at.state))
        _handed_out(self.get, status, at.state)
        if status not in {OK, WARNING}:
            return status
        size = c_size_t()
        status = call(self.size, at.state, ctypes.byref(size))
        if status not in {OK, WARNING}:
            return status
        if len(at.content) != size.value:
            at.content = self._room(size.value)
        return call(self.serialise, at.state, at.content, size.value)

    def keep(self, call: CallByName) -> tuple[int, c_void_p]:
        """The status, and the state as the FMU's own object; ``drop`` gives it back.

        Raises:
            StateError: none was handed out.
        """
        state = c_void_p()
        status = call(self.get, ctypes.byref(state))
        return _handed_out(self.get, status, state), state

    def put(self, call: CallByName, state: c_void_p) -> int:
        """Go back to a state that was kept, which stays."""
        return call(self.set, state)

    def drop(self, call: CallByName, state: c_void_p) -> int:
        """Give a kept state back."""
        return call(self.free, ctypes.byref(state))

    def load(self, call: CallByName, content: bytes) -> int:
        """Restore what was serialised; the first status that is neither OK nor a warning.

        Raises:
            StateError: no state was handed out.
        """
        state = c_void_p()
        room = (self.byte * len(content)).from_buffer_copy(content)
        status = call(self.deserialise, room, len(content), ctypes.byref(state))
        _handed_out(self.deserialise, status, state)
        if status not in {OK, WARNING}:
            return status
        return self._freed(call, state, call(self.set, state))

    def _room(self, size: int) -> Any:
        try:
            if size <= MOST_BYTES:
                return (self.byte * size)()
        except MemoryError:
            pass
        raise StateError(f"{self.size} says that its state has {size} bytes, more than can be kept")

    def _freed(self, call: CallByName, state: c_void_p, status: int) -> int:
        """Give a state back after ``status``, which stays the one that counts unless it is well."""
        if status == FATAL:
            return status  # nothing may be called any more
        freed = self.drop(call, state)
        return freed if status in {OK, WARNING} else status


def _handed_out(function: str, status: int, state: c_void_p) -> int:
    """The status of a call that gives a state, which has given one if it is well."""
    if status in {OK, WARNING} and not state:
        raise StateError(f"{function} said that all is well and handed out no state")
    return status


FMI2 = StateFunctions(
    get="fmi2GetFMUstate",
    set="fmi2SetFMUstate",
    free="fmi2FreeFMUstate",
    size="fmi2SerializedFMUstateSize",
    serialise="fmi2SerializeFMUstate",
    deserialise="fmi2DeSerializeFMUstate",
    byte=ctypes.c_char,
)
FMI3 = StateFunctions(
    get="fmi3GetFMUState",
    set="fmi3SetFMUState",
    free="fmi3FreeFMUState",
    size="fmi3SerializedFMUStateSize",
    serialise="fmi3SerializeFMUState",
    deserialise="fmi3DeserializeFMUState",
    byte=ctypes.c_uint8,
)
