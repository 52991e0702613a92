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
) -> Sample:
    """A sample of a device that counts."""
    first, second = (
        2 * pi * value / joint.counts_per_turn for value, joint in zip(count, joints, strict=True)
    )
    return Sample(shaft_angle=(first, second), count=count, sequence=sequence)


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


class WrappingClock:
    """A board's clock of 32 bits in microseconds, followed over its end.

    A step of more than half the range is one back: a board that has started anew.
    """

    def __init__(self) -> None:
        self._last: int | None = None
        self._total = 0

    def seconds(self, microseconds: int) -> float:
        """The time (s) that a reading stands for."""
        if self._last is None:
            self._total = microseconds
        else:
            step = (microseconds - self._last) & 0xFFFFFFFF
            self._total += step - (1 << 32 if step >= 1 << 31 else 0)
        self._last = microseconds
        return self._total * 1e-6
