"""An FMU's whole state as bytes, where it offers that: saved, serialised, restored, freed.

FMI 2.0.4 section 2.1.8, FMI 3.0 section 2.2.6; the functions of both differ in their names alone.
"""

from __future__ import annotations

import ctypes
from ctypes import POINTER, c_int, c_size_t, c_void_p
from dataclasses import dataclass
from typing import Any

from cosim.master.fmu.binding import OK, WARNING, Library, Prototype


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

    def save(self, library: Library, handle: int) -> tuple[int, bytes]:
        """The first status that is neither OK nor a warning, and the serialised state."""
        state, size = c_void_p(), c_size_t()
        status = library[self.get](handle, ctypes.byref(state))
        if status not in {OK, WARNING}:
            return status, b""
        content = b""
        status = library[self.size](handle, state, ctypes.byref(size))
        if status in {OK, WARNING}:
            room = (self.byte * size.value)()
            status = library[self.serialise](handle, state, room, size.value)
            content = bytes(room)
        freed = library[self.free](handle, ctypes.byref(state))
        return (status if status not in {OK, WARNING} else freed), content

    def keep(self, library: Library, handle: int) -> tuple[int, c_void_p]:
        """The status, and the state as the FMU's own object; ``drop`` gives it back."""
        state = c_void_p()
        return library[self.get](handle, ctypes.byref(state)), state

    def put(self, library: Library, handle: int, state: c_void_p) -> int:
        """Go back to a state that was kept, which stays."""
        return library[self.set](handle, state)

    def drop(self, library: Library, handle: int, state: c_void_p) -> int:
        """Give a kept state back."""
        return library[self.free](handle, ctypes.byref(state))

    def load(self, library: Library, handle: int, content: bytes) -> int:
        """Restore what was serialised; the first status that is neither OK nor a warning."""
        state = c_void_p()
        room = (self.byte * len(content)).from_buffer_copy(content)
        status = library[self.deserialise](handle, room, len(content), ctypes.byref(state))
        if status not in {OK, WARNING}:
            return status
        status = library[self.set](handle, state)
        freed = library[self.free](handle, ctypes.byref(state))
        return status if status not in {OK, WARNING} else freed


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
