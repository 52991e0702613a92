"""One CANopen node: encoder channels and analogue outputs behind its object dictionary."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field
from math import pi
from typing import Any

from hil.drivers.canopen.emulated_local import Local, LocalWire
from hil.drivers.canopen.emulated_mapping import MappedNode
from hil.drivers.canopen.emulated_objects import dictionary
from hil.emulation.world import World

MAPPABLE = frozenset(
    {(0, 0, 0), (0x6004, 0, 32), (0x6020, 1, 32), (0x6020, 2, 32), (0x6411, 1, 16), (0x6411, 2, 16)}
)
TORQUE_PER_CODE = 10.0 / 32767 * 0.5 * 0.0364
"""A DAC of +-10 V, an amplifier of 0.5 A/V and a motor of 0.0364 N.m/A (N.m)."""
LARGEST_CODE = 32767


@dataclass
class Axes:
    """Which joints a node's channels belong to: object -> joint."""

    positions: dict[tuple[int, int], int] = field(default_factory=dict[tuple[int, int], int])
    outputs: dict[int, int] = field(default_factory=dict[int, int])
    """Sub-index of 6411h -> joint."""


class EmulatedNode(MappedNode):
    """One node with encoder channels and analogue outputs."""

    mappable = MAPPABLE

    def __init__(self, number: int, its: Axes, wire: LocalWire, world: World) -> None:
        super().__init__(number, Local(number, dictionary(number)), wire)
        self.its, self._world = its, world
        self.local.add_read_callback(self._read)
        self.local.add_write_callback(self._write)
        self.driven = dict.fromkeys(its.outputs, 0)
        """What the output stage gives (codes)."""
        self._zero = dict.fromkeys(its.positions, 0)
        self.boot()

    def drive(self) -> None:
        """The output stage follows the dictionary, or its error mode."""
        for channel in self.driven:
            if not self.failed and self.local.nmt.state != "STOPPED":
                self.driven[channel] = self.value(0x6411, channel)
            elif self.value(0x6443, channel):
                wanted = self.value(0x6444, channel)
                self.driven[channel] = max(-LARGEST_CODE, min(LARGEST_CODE, wanted))

    def torque(self) -> dict[int, float]:
        """What its outputs make the motors give."""
        return {
            joint: self.driven[channel] * TORQUE_PER_CODE
            for channel, joint in self.its.outputs.items()
        }

    def _read(self, index: int, subindex: int, **_: Any) -> int | None:
        joint = self.its.positions.get((index, subindex))
        if joint is None:
            return None
        span = self.value(0x6002, 0) or 1 << 32
        return (self._count(joint) + self._zero[index, subindex]) % span

    def _count(self, joint: int) -> int:
        return round(self._world.angle()[joint] / (2 * pi) * self.value(0x6001, 0))

    def _write(self, index: int, subindex: int, data: bytes, **_: Any) -> None:
        if 0x1A00 <= index <= 0x1A01 or index == 0x1600:
            self._check_mapping(index, subindex, int.from_bytes(data, "little"))
        if index == 0x1016:
            self._heard = None
        place = {0x6003: (0x6004, 0), 0x6010: (0x6020, subindex)}.get(index)
        if place in self.its.positions:
            (wanted,) = struct.unpack("<i", data)
            self._zero[place] = wanted - self._count(self.its.positions[place])
