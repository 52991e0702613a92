"""Which way a joint counts, found by turning it."""

from __future__ import annotations

from hil.device.device import Device
from hil.device.errors import DeviceError
from hil.setup.calibrate.turner import Turner
from hil.setup.look import newest_angles

LEAST_TURN = 0.1
"""A joint that turned less (rad) did not turn on purpose."""


def directions(device: Device, turner: Turner) -> tuple[int, int]:
    """The signs that make joint angles grow counterclockwise (seen from above).

    Raises:
        DeviceError: a joint did not turn.
    """
    signs: list[int] = []
    for axis in (0, 1):
        turner.leave(axis)
        before = newest_angles(device)[axis]
        turner.turn(axis)
        turned = newest_angles(device)[axis] - before
        turner.let_go()
        if abs(turned) < LEAST_TURN:
            raise DeviceError(
                f"joint {axis + 1} turned by {turned:.3f} rad only: is its encoder connected?"
            )
        signs.append(device.file.joints[axis].direction * (1 if turned > 0 else -1))
    return signs[0], signs[1]
