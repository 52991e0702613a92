"""A model of ours in Python without FMI: what its author uses to try and to test it.

>>> hand = Instance("hand", mass=0.4)
>>> hand.initialise()
>>> hand["force"] = 1.0
>>> hand.step()
>>> hand["velocity"]
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.builder import build_development, load_model
from fmus.layout import STRING_SLOTS, Placed, SlotElement, SlotLayout
from fmus.table import Model


class ModelError(Exception):
    """What a model said in ``model_initialise`` or ``model_step``."""


class Instance:
    """One instance of a model, on its own memory; values are read and written by variable path.

    An array is read and written whole (``instance["force"] = [1, 0]``) or by element
    (``instance["force[1]"]``). Reading a computed variable evaluates ``model_outputs`` first.
    """

    def __init__(
        self, model: Model | str, *, folder: Path | None = None, **parameters: Any
    ) -> None:
        self.model = load_model(model) if isinstance(model, str) else model
        self.layout = SlotLayout(self.model)
        self.time = 0.0
        self._places: dict[str, Placed | SlotElement] = {
            **{placed.path: placed for placed in self.layout.placed},
            **{element.name: element for element in self.layout.elements},
        }
        self._places.update({placed.path: placed for placed in self.layout.placed})
        self._library = _load(build_development(self.model, folder=folder))
        self._slots = np.zeros(max(self.layout.slots, 1), np.int64)
        room = np.zeros((self._library.development_state_room() + 7) // 8, np.int64)
        size = (self._library.development_state_size() + 7) // 8
        self._state, self._work = room[:size], room[size:]
        for placed in self.layout.placed:
            if placed.variable.start is not None:
                self[placed.path] = placed.variable.start
        self.set(parameters)

    def set(self, values: Mapping[str, Any]) -> None:
        """Set several variables at once."""
        for path, value in values.items():
            self[path] = value

    def initialise(self, at: float = 0.0, /, **parameters: Any) -> None:
        """Set parameters and start at time ``at`` (s).

        Raises:
            ModelError: the model refused its parameters.
        """
        self.set(parameters)
        self.time = at
        self._raise(
            self._library.development_initialise(
                self._slots.ctypes.data, self._state.ctypes.data, at
            )
        )

    def step(self, h: float | None = None) -> None:
        """Advance by ``h`` (s), the model's default step unless given.

        Raises:
            ModelError: the model refused the step.
        """
        h = self.model.default_step if h is None else h
        self._raise(
            self._library.development_step(
                self._slots.ctypes.data, self._state.ctypes.data, self.time, h
            )
        )
        self.time += h

    @property
    def state(self) -> bytes:
        """The committed state and all variables, to compare and to put back."""
        return self._state.tobytes() + self._slots.tobytes()

    @state.setter
    def state(self, value: bytes) -> None:
        cells = np.frombuffer(value, np.int64)
        self._state[:] = cells[: self._state.size]
        self._work[:] = 0
        self._slots[:] = cells[self._state.size :]

    def __getitem__(self, path: str) -> Any:
        place = self._place(path)
        if place.variable.causality in {"output", "local"}:
            self._library.development_outputs(self._slots.ctypes.data, self._state.ctypes.data)
        if place.variable.type == "string":
            return self._text(place.slot).tobytes().split(b"\0")[0].decode()
        cells = self._cells(place).copy()
        whole = isinstance(place, Placed) and place.variable.size is not None
        return cells if whole else cells[0].item()

    def __setitem__(self, path: str, value: Any) -> None:
        place = self._place(path)
        if place.variable.type == "string":
            data = str(value).encode() + b"\0"
            self._text(place.slot)[: len(data)] = np.frombuffer(data, np.uint8)
        else:
            self._cells(place)[:] = value

    def _place(self, path: str) -> Placed | SlotElement:
        if path not in self._places:
            raise KeyError(f"model {self.model.name} has no variable '{path}'")
        return self._places[path]

    def _cells(self, place: Placed | SlotElement) -> NDArray[Any]:
        size = place.variable.size or 1 if isinstance(place, Placed) else 1
        cells = self._slots[place.slot : place.slot + size]
        return cells.view(np.float64) if place.variable.type == "real" else cells

    def _text(self, slot: int) -> NDArray[np.uint8]:
        return self._slots[slot : slot + STRING_SLOTS].view(np.uint8)

    def _raise(self, message: bytes | None) -> None:
        if message is not None:
            raise ModelError(message.decode(errors="replace"))


def _load(path: Path) -> Any:
    library = ctypes.CDLL(str(path))
    pointer, double = ctypes.c_void_p, ctypes.c_double
    library.development_state_size.restype = ctypes.c_size_t
    library.development_state_room.restype = ctypes.c_size_t
    library.development_initialise.restype = ctypes.c_char_p
    library.development_initialise.argtypes = (pointer, pointer, double)
    library.development_outputs.restype = None
    library.development_outputs.argtypes = (pointer, pointer)
    library.development_step.restype = ctypes.c_char_p
    library.development_step.argtypes = (pointer, pointer, double, double)
    return library
