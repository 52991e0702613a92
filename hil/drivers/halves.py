"""Torques that go to several nodes in frames of their own: what is on the wire where one fails."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from hil.device.errors import DeviceGone, HalfSent
from hil.safety.linkage import Pair

Part = tuple[Sequence[int], int, bytes]
"""Joints whose torques a frame has, its identifier and its data."""


def send_each(send: Callable[[int, bytes], object], torque: Pair, parts: Sequence[Part]) -> None:
    """Send one frame after the other, each with the torques of some joints.

    Raises:
        HalfSent: one did not go out, and others had.
        DeviceGone: the first one did not.
    """
    done = 0
    try:
        for _, identifier, data in parts:
            send(identifier, data)
            done += 1
    except DeviceGone as error:
        if not done:
            raise
        out = {joint: torque[joint] for joints, _, _ in parts[:done] for joint in joints}
        raise HalfSent(str(error), out) from error
