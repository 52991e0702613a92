"""How a run ended."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from cosim.master.channels.packets import PacketCount
from cosim.master.fmu.log import Said


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """How far a run came, and what was counted on the way."""

    ticks: int
    wall_time: float
    """Time spent in the loop (s), without start-up and shut-down."""
    interrupted: bool
    channels: Mapping[str, PacketCount] = field(default_factory=dict[str, PacketCount])
    warnings: Mapping[str, int] = field(default_factory=dict[str, int])
    """Warnings that FMUs returned, by component."""
    ended_by: str = ""
    """The sentence of the model that asked for the end, which is a good one."""
    said: Mapping[str, tuple[Said, ...]] = field(default_factory=dict[str, "tuple[Said, ...]"])
    """What FMUs said that was not well, by component."""
