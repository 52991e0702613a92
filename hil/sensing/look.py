"""``cohaptic device check`` of a sensor: it is asked, and what comes is shown."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from hil.sensing.reading import Wrench
from hil.sensing.sensor import Sensor


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorCheck:
    """What a look at a sensor showed; times in s, forces in N, torques in N.m."""

    exchanges: int
    samples: int
    oldest_sample: int
    """The oldest data in ticks."""
    rate: float
    """Exchanges a second."""
    median: float
    p99: float
    worst: float
    """Time of one exchange."""
    lowest: tuple[float, ...]
    highest: tuple[float, ...]
    """Force x, y, z and torque x, y, z that were seen; infinite where nothing measures."""
    fault: str | None


def check_sensor(
    sensor: Sensor, seconds: float, show: Callable[[Wrench, int], None] | None = None
) -> SensorCheck:
    """Exchange with an open sensor for some time (in lock-step: of its ticks).

    ``show`` gets the wrench and its age about ten times a second.
    """
    spent: list[float] = []
    samples = oldest = exchanges = 0
    lowest, highest = [inf] * 6, [-inf] * 6
    began = told = time.monotonic()
    while (exchanges * sensor.tick if sensor.lockstep else time.monotonic() - began) < seconds:
        before = time.monotonic()
        wrench = sensor.read()
        sensor.ask()
        spent.append(time.monotonic() - before)
        samples += sensor.age == 0
        oldest = max(oldest, sensor.age)
        for axis, value in enumerate((*wrench.force, *wrench.torque)):
            lowest[axis], highest[axis] = min(lowest[axis], value), max(highest[axis], value)
        if show is not None and before - told > 0.1:
            told = before
            show(wrench, sensor.age)
        exchanges += 1
        sensor.driver.pause()
        if sensor.fault is not None:
            break
    ordered = sorted(spent)
    return SensorCheck(
        exchanges=exchanges,
        samples=samples,
        oldest_sample=oldest,
        rate=exchanges / (time.monotonic() - began),
        median=ordered[len(ordered) // 2],
        p99=ordered[int(0.99 * (len(ordered) - 1))],
        worst=ordered[-1],
        lowest=tuple(lowest),
        highest=tuple(highest),
        fault=None if sensor.fault is None else sensor.fault_sentence(),
    )
