"""What a driver received, as the sample that the device is given."""

from __future__ import annotations

from math import pi

from hil.device.contract import Sample
from hil.safety.linkage import Pair
from hil.setup.device_file import Joint


def sample_of_counts(
    joints: tuple[Joint, Joint],
    count: tuple[int, int],
    sequence: int,
    *,
    device_time: float | None = None,
) -> Sample:
    """A sample of a device that counts; ``device_time`` (s) where it has a clock."""
    first, second = (
        2 * pi * value / joint.counts_per_turn for value, joint in zip(count, joints, strict=True)
    )
    return Sample(
        shaft_angle=(first, second), count=count, sequence=sequence, device_time=device_time
    )


def sample_of_turns(joints: tuple[Joint, Joint], turns: Pair, sequence: int) -> Sample:
    """A sample of a device that reports turns of the shaft."""
    first, second = (
        round(turn * joint.counts_per_turn) for turn, joint in zip(turns, joints, strict=True)
    )
    return Sample(
        shaft_angle=(2 * pi * turns[0], 2 * pi * turns[1]),
        count=(first, second),
        sequence=sequence,
    )
