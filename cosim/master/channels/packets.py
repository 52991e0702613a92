"""The memory of the bundles: packets in flight, their drawn fates, and what was counted."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.layout import Layout
from cosim.master.assembly.wiring import Bundle
from cosim.master.channels.fates import NO_COPY, FateStream
from cosim.master.kernel.structures import BundleStruct
from cosim.scenario import Direction

BLOCK = 1024
"""Packets whose fates are drawn at a time; no chunk of ticks may send more."""

_KEPT = (
    *("sampled", "sequence", "immediate", "fate_first", "fate_count", "in_flight", "next_arrival"),
    *("sent", "delivered", "lost", "late", "duplicate"),
)
"""The members of a bundle that change while it runs; the others follow from the scenario."""

NEVER = int(np.iinfo(np.int64).max)


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketCount:
    """What became of the packets of one direction of a channel.

    ``sent == delivered + late + lost + in_flight``; ``duplicate`` counts second copies, which are
    dropped. ``late`` packets arrived after (or in the same tick as) a newer one and were dropped.
    """

    sent: int
    delivered: int
    lost: int
    late: int
    duplicate: int
    in_flight: int


class Packets:
    """The kernel's bundles."""

    def __init__(self, bundles: Sequence[Bundle], layout: Layout, cells: NDArray[np.int64]) -> None:
        self.bundles = bundles
        self._streams: list[FateStream] = [bundle.fates.begin() for bundle in bundles]
        self.structs: Any = (BundleStruct * max(len(bundles), 1))()
        self._can_be_immediate = [bundle.can_be_immediate for bundle in bundles]
        self._cells = cells
        self._keep: list[NDArray[Any]] = []
        self._flight: list[NDArray[np.int64]] = []
        self._payload: list[NDArray[np.int64]] = []
        self._fates: dict[int, tuple[NDArray[np.int64], NDArray[np.int64]]] = {}
        for number, bundle in enumerate(bundles):
            self._fill(number, bundle, layout)
        self._first = bytes(self.structs)
        self.draw()

    def flying(self, number: int) -> NDArray[np.int64]:
        """The values of a bundle's packets in flight, shape (packets, entries)."""
        return self._payload[number][: int(self.structs[number].in_flight)]

    def rewind(self, bundles: Sequence[Bundle], layout: Layout) -> bool:
        """Be before the first packet again; ``False`` where there may have to be other tables."""
        for one, two in zip(self.bundles, bundles, strict=True):
            if one.fates is not two.fates and not one.fates.has_ways_of(two.fates):
                return False
        self.bundles = bundles
        self._streams = [FateStream(bundle.fates) for bundle in bundles]
        ctypes.memmove(self.structs, self._first, len(self._first))
        for number in range(len(bundles)):
            self._cells[layout.sequence[number]] = -1
        self.draw()
        return True

    def draw(self) -> None:
        """See to it that the fates of the next ``BLOCK`` packets are drawn."""
        for number, (delays, copies) in self._fates.items():
            struct = self.structs[number]
            used = struct.sequence - struct.fate_first
            left = struct.fate_count - used
            if left >= BLOCK:
                continue
            fresh = self._streams[number].take(2 * BLOCK - left)
            for table, drawn in zip((delays, copies), fresh, strict=True):
                table[:left] = table[used : used + left].copy()
                table[left:] = drawn
            struct.fate_first = struct.sequence
            struct.fate_count = 2 * BLOCK
        for number in range(len(self.bundles)):
            struct = self.structs[number]
            if struct.sequence == 0:  # initialisation mode asks whether packet 0 has no delay
                delay = self._fates[number][0][0] if number in self._fates else struct.delay
                struct.immediate = int(self._can_be_immediate[number] and delay == 0)

    def turn(self, number: int, direction: Direction) -> None:
        """What is sent from now on goes by another direction; what flies keeps its fate."""
        struct = self.structs[number]
        stream = self._streams[number]
        stream.turn(direction, struct.sequence)
        struct.delay = direction.delay.ticks
        if number in self._fates:
            for table, drawn in zip(self._fates[number], stream.take(BLOCK), strict=True):
                table[:BLOCK] = drawn
            struct.fate_first, struct.fate_count = struct.sequence, BLOCK

    def fix(self, number: int, delay: int) -> None:
        """Before the first is sent: every packet takes this delay (ticks), nothing is drawn.

        Raises:
            ValueError: there is no room for so many packets in flight.
        """
        struct = self.structs[number]
        if 2 * (delay // struct.period + 2) > struct.capacity:
            raise ValueError(f"there is no room for packets that are {delay} ticks late")
        self._fates.pop(number, None)
        struct.fates = struct.copies = None
        struct.delay = delay
        struct.immediate = int(self._can_be_immediate[number] and delay == 0)

    def take_back(self, number: int, direction: Direction) -> None:
        """The direction that is in force where a snapshot goes on; ``load`` comes next."""
        self._streams[number].turn(direction)
        self.structs[number].delay = direction.delay.ticks

    def save(self, number: int) -> tuple[dict[str, Any], dict[str, NDArray[np.int64]]]:
        """A bundle's counters and what its draws remember; its packets and drawn fates."""
        struct = self.structs[number]
        flying = int(struct.in_flight)
        arrays = {
            "flight": self._flight[number][:, :flying].copy(),
            "payload": self.flying(number).copy(),
        }
        if number in self._fates:
            arrays["fates"] = np.array(self._fates[number])
        values = {name: int(getattr(struct, name)) for name in _KEPT}
        return values | {"draws": self._streams[number].save()}, arrays

    def load(
        self, number: int, values: Mapping[str, Any], arrays: Mapping[str, NDArray[np.int64]]
    ) -> None:
        """Go on from what ``save`` returned.

        Raises:
            KeyError, TypeError, ValueError: it is not of this bundle.
        """
        struct = self.structs[number]
        kept = {name: int(values[name]) for name in _KEPT}
        flying = kept["in_flight"]
        drawn = kept["fate_first"] + kept["fate_count"] - kept["sequence"]
        if not 0 <= flying <= struct.capacity or (
            number in self._fates and not 0 <= drawn <= kept["fate_count"] <= 2 * BLOCK
        ):
            raise ValueError("there are more packets in flight, or fewer drawn, than there can be")
        if number in self._fates:
            for table, saved in zip(self._fates[number], arrays["fates"], strict=True):
                table[:] = saved
        self._streams[number].load(values["draws"])
        self._flight[number][:, :flying] = arrays["flight"]
        self._payload[number][:flying] = arrays["payload"]
        for name, value in kept.items():
            setattr(struct, name, value)

    def branch(
        self, number: int, values: Mapping[str, Any], arrays: Mapping[str, NDArray[np.int64]]
    ) -> None:
        """Go on from what another run's ``save`` returned, with fates of this run's own.

        Packets under way arrive as that run had it.

        Raises:
            ValueError: there are more of them than there is room for.
        """
        struct = self.structs[number]
        kept = {name: int(values[name]) for name in _KEPT}
        flying = kept["in_flight"]
        if flying > struct.capacity:
            raise ValueError(f"{flying} packets are under way, and there is room for less")
        self._flight[number][:, :flying] = arrays["flight"]
        self._payload[number][:flying] = arrays["payload"]
        kept |= {"fate_first": kept["sequence"], "fate_count": 0}
        for name, value in kept.items():
            setattr(struct, name, value)
        if number in self._fates:
            fates = self.bundles[number].fates
            self._streams[number].turn(fates.direction, kept["sequence"])
            self.draw()

    def counts(self) -> dict[str, PacketCount]:
        """The count of every direction of every channel, by its name."""
        return {
            bundle.name: PacketCount(
                sent=struct.sent,
                delivered=struct.delivered,
                lost=struct.lost,
                late=struct.late,
                duplicate=struct.duplicate,
                in_flight=self._in_flight(number),
            )
            for number, bundle in enumerate(self.bundles)
            if bundle.channel is not None and (struct := self.structs[number])
        }

    def _in_flight(self, number: int) -> int:
        flying = self.structs[number].in_flight
        return int(np.count_nonzero(self._flight[number][2, :flying] >= 0)) if flying else 0

    def _fill(self, number: int, bundle: Bundle, layout: Layout) -> None:
        width = len(bundle.entries)
        capacity = 2 * (bundle.fates.longest // bundle.period + 2)
        sources = np.array([layout.of(entry.source) for entry in bundle.entries], dtype=np.int32)
        flight = np.zeros((3, capacity), dtype=np.int64)
        payload = np.zeros((capacity, max(width, 1)), dtype=np.int64)
        self._keep.append(sources)
        self._flight.append(flight)
        self._payload.append(payload)
        base = self._cells.ctypes.data
        self._cells[layout.sequence[number]] = -1
        struct = self.structs[number]
        struct.period = bundle.period
        struct.width = width
        struct.sources = sources.ctypes.data
        struct.held = base + 8 * layout.held[number]
        struct.age = base + 8 * layout.age[number]
        struct.held_sequence = base + 8 * layout.sequence[number]
        struct.delay = bundle.fates.direction.delay.ticks
        struct.capacity = capacity
        struct.next_arrival = NEVER
        struct.arrival, struct.flight_sequence, struct.flight_sampled = (
            row.ctypes.data for row in flight
        )
        struct.payload = payload.ctypes.data
        if not bundle.fates.is_constant:
            delays = np.zeros(2 * BLOCK, dtype=np.int64)
            copies = np.full(2 * BLOCK, NO_COPY, dtype=np.int64)
            self._fates[number] = (delays, copies)
            struct.fates = delays.ctypes.data
            struct.copies = copies.ctypes.data
