"""The PyPI package ``canopen`` behind an emulated node: its SDO server, NMT slave and emergencies.

No bus and no thread: what the package sends is collected, what it would repeat is put on a list.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import canopen

from hil.emulation.board import BoardFrame, Unit


@dataclass
class Periodic:
    """A heartbeat that the NMT slave wants to have sent; the board's clock does it."""

    identifier: int
    data: bytes
    period: float
    due: float = 0.0
    stopped: bool = False

    def update(self, data: Any) -> None:
        """Send this from now on."""
        self.data = bytes(data)

    def stop(self) -> None:
        """Send it no more."""
        self.stopped = True


class LocalWire(canopen.Network):
    """What the package's local nodes send into; no bus and no thread behind it."""

    def __init__(self) -> None:
        super().__init__()
        self.frames: list[BoardFrame] = []
        self.periodic: list[Periodic] = []

    def send_message(self, can_id: int, data: Any, remote: bool = False) -> None:
        """Collect a frame."""
        self.frames.append(BoardFrame(can_id, bytes(data)))

    def send_periodic(
        self,
        can_id: int,
        data: Any,
        period: float,
        remote: bool = False,
    ) -> Any:
        """Put a heartbeat on the list."""
        made = Periodic(can_id, bytes(data), period)
        self.periodic.append(made)
        return made

    def taken(self) -> list[Unit]:
        """What was sent since the last time."""
        frames, self.frames = self.frames, []
        return [*frames]


class Local(canopen.LocalNode):
    """The package's local node, which remembers the values that every tick needs."""

    def __init__(self, number: int, objects: canopen.ObjectDictionary) -> None:
        super().__init__(number, objects)
        self._known: dict[tuple[int, int], int] = {}

    def value(self, index: int, subindex: int) -> int:
        """A number of the dictionary (not a position, which changes by itself)."""
        place = index, subindex
        if place not in self._known:
            variable: Any = self.object_dictionary.get_variable(index, subindex)
            self._known[place] = int(variable.decode_raw(self.get_data(index, subindex)))
        return self._known[place]

    def set_data(self, index: int, subindex: int, data: Any, check_writable: Any = False) -> None:
        """Write an entry; its remembered value is forgotten."""
        super().set_data(index, subindex, data, check_writable)
        self._known.pop((index, subindex), None)

    def forget(self) -> None:
        """Everything is as after power-on."""
        self.data_store.clear()
        self._known.clear()
