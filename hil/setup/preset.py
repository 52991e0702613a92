"""What a maker publishes of a device: geometry, encoder, motor, and where its handle rests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hil.safety.linkage import Linkage, Pair


@dataclass(frozen=True, slots=True, kw_only=True)
class Motor:
    """What a motor is rated for, at its own shaft."""

    peak_torque: float
    """Torque that it gives for seconds at most (N.m)."""
    continuous_torque: float
    """Torque that it may hold for ever (N.m)."""
    peak_current: float | None = None
    """Current (A) that it, or its amplifier, takes at most; ``None`` where nothing commands one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Preset:
    """One published device; the class of a driver names those that come with it."""

    linkage: Linkage
    counts_per_turn: int
    motor: Motor
    drive: Mapping[str, float] = field(default_factory=dict[str, float])
    """Torque constant (N.m/A) and amplifier (A/V), for a drive that takes volts."""
    limits: Mapping[str, float] = field(default_factory=dict[str, float])
    """Limits that are tighter than the house's defaults."""
    rest: Pair
    """A tip position (m) in the middle of its workspace."""
    model: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Parameters of the pantograph FMU that simulate it."""

    @property
    def parameters(self) -> dict[str, Any]:
        """The FMU's parameters for a device of this kind at rest."""
        return {**self.model, "initial_tip_position": self.rest}
