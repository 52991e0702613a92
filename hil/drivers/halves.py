"""Torques that go to several nodes in frames of their own: what is on the wire where one fails."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from hil.device.errors import DeviceGone, HalfSent
from hil.safety.linkage import Pair


def send_each(torque: Pair, frames: Iterable[tuple[tuple[int, ...], Callable[[], object]]]) -> None:
    """Send one frame after the other, each with the torques of some joints.

    Raises:
        HalfSent: one did not go out, and others had.
        DeviceGone: the first one did not.
    """
    out: dict[int, float] = {}
    for joints, send in frames:
        try:
            send()
        except DeviceGone as error:
            if not out:
                raise
            raise HalfSent(str(error), out) from error
        out |= {joint: torque[joint] for joint in joints}
