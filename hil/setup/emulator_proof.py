"""How an emulator proves that it is one: it moves without force, by an amount told only to it.

The side channel is told two random angles; if the angles that the driver reads over the device's
own wire then shift by exactly those, there is no hand and no motor behind that wire.
"""

from __future__ import annotations

from contextlib import closing
from math import pi
from random import SystemRandom
from typing import TYPE_CHECKING

from hil.device.errors import DeviceError
from hil.setup.look import newest_angles
from hil.wire.side_channel import Control

if TYPE_CHECKING:
    from hil.device.device import Device

SHOWN = 5
"""New samples by which a pipelined protocol, too, shows a change."""


def doubt(device: Device) -> str | None:
    """Why a configured, inactive device may not be an emulator; ``None`` once it proved to be one.

    It needs ``emulator=`` in its URL.
    """
    path = device.address.emulator
    if path is None:
        return "its URL names no emulator"
    random = SystemRandom()
    shift = (random.uniform(0.1, 0.4), random.uniform(-0.4, -0.1))
    try:
        with closing(Control(path)) as control:
            before = newest_angles(device, SHOWN)
            control.ask("shift", by=shift)
            moved = newest_angles(device, SHOWN)
            control.ask("shift", by=(0.0, 0.0))
            after = newest_angles(device, SHOWN)
    except DeviceError as error:
        return str(error)
    allowed = 3 * max(2 * pi / joint.counts_per_turn for joint in device.file.joints)
    shown = all(
        abs(abs(moved[axis] - before[axis]) - abs(shift[axis])) < allowed
        and abs(after[axis] - before[axis]) < allowed
        for axis in (0, 1)
    )
    return None if shown else "its angles did not move as the emulator was told to move them"
