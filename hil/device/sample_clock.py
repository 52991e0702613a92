"""From what a driver received to calibrated joint angles, and how old they are."""

from __future__ import annotations

import math

from hil.device.contract import Sample
from hil.safety.linkage import Pair
from hil.setup.device_file import DeviceFile


class SampleClock:
    """The newest sample, its age in ticks, the board's own time, and what homing found."""

    def __init__(self, file: DeviceFile, *, oldest: int) -> None:
        self._joints = file.joints
        self._offset: Pair | None = None
        """Of the joints (rad), found by homing; before it, the device file's."""
        self.sample: Sample | None = None
        self.device_time: float | None = None
        """The board's clock (s) at the newest sample."""
        self.age = oldest

    def restart(self) -> None:
        """The port was opened: nothing has come yet."""
        self.sample, self.device_time, self.age = None, None, 0

    def take(self, sample: Sample, device_time: float | None) -> None:
        """A new valid sample."""
        self.sample, self.device_time = sample, device_time

    def tick(self, *, fresh: bool) -> None:
        """One more tick, with a new sample or without."""
        self.age = 0 if fresh else self.age + 1

    def joint_angle(self) -> Pair:
        """Joint angles (rad), nan before the first sample."""
        if self.sample is None:
            return math.nan, math.nan
        first, second = self._joints
        offset = self._offset or (first.offset, second.offset)
        shaft = self.sample.shaft_angle
        return (
            first.direction * shaft[0] + offset[0],
            second.direction * shaft[1] + offset[1],
        )

    def set_home(self, home: Pair) -> None:
        """Make the newest sample's shaft angles the joint angles ``home`` (rad)."""
        assert self.sample is not None, "homing waits for a sample"
        shaft = self.sample.shaft_angle
        first, second = self._joints
        self._offset = (
            home[0] - first.direction * shaft[0],
            home[1] - second.direction * shaft[1],
        )
