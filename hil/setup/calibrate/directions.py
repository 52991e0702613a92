"""Which way a joint counts, found by turning it."""

from __future__ import annotations

from hil.device.contract import ZERO
from hil.device.device import Device
from hil.device.errors import DeviceError
from hil.setup.calibrate.turner import Turner

LEAST_TURN = 0.1
"""A joint that turned less (rad) did not turn on purpose."""
READS = 8
"""New samples of which the last one counts."""


def directions(device: Device, turner: Turner) -> tuple[int, int]:
    """The signs that make joint angles grow counterclockwise (seen from above).

    Raises:
        DeviceError: a joint did not turn.
    """
    signs: list[int] = []
    for axis in (0, 1):
        turner.leave(axis)
        before = _angle(device, axis)
        turner.turn(axis)
        turned = _angle(device, axis) - before
        turner.let_go()
        if abs(turned) < LEAST_TURN:
            raise DeviceError(
                f"joint {axis + 1} turned by {turned:.3f} rad only: is its encoder connected?"
            )
        signs.append(device.file.joints[axis].direction * (1 if turned > 0 else -1))
    return signs[0], signs[1]


def _angle(device: Device, axis: int) -> float:
    """Of the last of some new samples: what is held from before a turn says nothing of it.

    Raises:
        DeviceError: the device fell silent.
    """
    tick = new = 0
    while True:
        measured = device.read(tick)
        new += measured.sample_age == 0
        if new == READS:
            return measured.joint_angle[axis]
        device.write(tick, ZERO)
        device.driver.pause()
        device.raise_fault()
        tick += 1
