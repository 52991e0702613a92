"""What a maker publishes of a sensor: its channels, each with its share in force and torque."""

from __future__ import annotations

from dataclasses import dataclass

Vector = tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class LoadChannel:
    """One converter: counts above ``zero``, each worth so much along x, y and z."""

    force: Vector = (0.0, 0.0, 0.0)
    """N per count."""
    torque: Vector = (0.0, 0.0, 0.0)
    """N.m per count."""
    zero: int = 0
    """Counts without load."""
    full_scale: int
    """Counts (either sign) at which the converter, or the sensor, is at the end of its range."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorPreset:
    """One published sensor."""

    channels: tuple[LoadChannel, ...]
