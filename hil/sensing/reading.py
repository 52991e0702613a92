"""The values that a sensor, its driver and the rest of cohaptic exchange every tick."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag

from hil.device.errors import DeviceError


class SensorStatus(IntFlag):
    """The bits of a sensor's ``status`` output."""

    OPEN = 1
    """It measures; without ``FAULT`` its newest value is fit for use."""
    FAULT = 2
    SATURATED = 4
    """A channel stood at the end of its range in the newest answer; the value before it is held."""


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force (N) and torque (N.m) along x, y and z; NaN along an axis that nothing measures."""

    force: tuple[float, float, float]
    torque: tuple[float, float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """What ``SensorDriver.receive`` returns. Every field is judged by the sensor."""

    counts: tuple[int, ...] | None = None
    """Raw counts of all channels in the newest valid answer that is not late."""
    clipped: frozenset[int] = frozenset()
    """Channels that the board says stood at the end of their range."""
    device_time: float | None = None
    """The board's own clock (s), where an answer came."""
    error: DeviceError | None = None
    """What the board says is wrong with it, or what its answers make no sense of."""
    earlier: tuple[Heard, ...] = ()
    """What came before it in the same tick, the oldest first: judged, and no new sample."""

    @property
    def each(self) -> tuple[Heard, ...]:
        """All that came in the tick, the oldest first."""
        return (*self.earlier, self)


SILENT = Heard()
