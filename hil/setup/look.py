"""A safe look at a device, such as ``cohaptic device check``: it commands nothing but zero.

The user moves the handle and sees the angles; round trips, ages and rate are measured on the way.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf

from hil.device.contract import ZERO
from hil.device.device import Device
from hil.safety.linkage import Pair

SAMPLES = 8
"""New samples of which the last one counts: by then every answer under way has come."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """What a look at a device showed; times in s."""

    exchanges: int
    samples: int
    oldest_sample: int
    """The oldest data in ticks."""
    rate: float
    """Exchanges a second."""
    median: float
    p99: float
    worst: float
    """Time of one read and write."""
    lowest: Pair
    highest: Pair
    """Joint angles that were seen (rad; from the pose at power-on where it is not homed)."""
    fault: str | None


def check(device: Device, seconds: float, show: Callable[[Pair, int], None] | None = None) -> Check:
    """Exchange zeros with a configured device for some time (in lock-step: of its ticks).

    ``show`` gets joint angles and sample age about ten times a second.
    """
    spent: list[float] = []
    samples = oldest = 0
    lowest, highest = (inf, inf), (-inf, -inf)
    began = told = time.monotonic()
    tick = 0
    while (tick * device.tick if device.lockstep else time.monotonic() - began) < seconds:
        before = time.monotonic()
        measured = device.read(tick)
        device.write(tick, ZERO)
        spent.append(time.monotonic() - before)
        samples += measured.sample_age == 0
        oldest = max(oldest, measured.sample_age)
        angle = measured.joint_angle
        if measured.sequence >= 0:
            lowest = (min(lowest[0], angle[0]), min(lowest[1], angle[1]))
            highest = (max(highest[0], angle[0]), max(highest[1], angle[1]))
        if show is not None and before - told > 0.1:
            told = before
            show(angle, measured.sample_age)
        tick += 1
        device.driver.pause()
        if device.settled:
            break
    ordered = sorted(spent)
    return Check(
        exchanges=tick,
        samples=samples,
        oldest_sample=oldest,
        rate=tick / (time.monotonic() - began),
        median=ordered[len(ordered) // 2],
        p99=ordered[int(0.99 * (len(ordered) - 1))],
        worst=ordered[-1],
        lowest=lowest,
        highest=highest,
        fault=device.fault_sentence() if device.fault is not None else None,
    )


def newest_angles(device: Device, samples: int = SAMPLES) -> Pair:
    """Joint angles (rad) of the last of some new samples, at zero torque.

    What is held from before says nothing of what has happened since.

    Raises:
        DeviceError: the device fell silent.
    """
    tick = new = 0
    while True:
        measured = device.read(tick)
        new += measured.sample_age == 0
        if new == samples:
            return measured.joint_angle
        device.write(tick, ZERO)
        device.driver.pause()
        device.raise_fault()
        tick += 1
