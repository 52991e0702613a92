"""From what a driver received to calibrated joint angles."""

from __future__ import annotations

import math
from typing import final

from hil.device.contract import Sample, State
from hil.device.errors import DeviceError
from hil.realtime.after_death import AfterDeath
from hil.safety.limits import DROP_TICKS
from hil.safety.linkage import Pair

FIRST_SAMPLE_TRIES = 50
"""Exchanges within which a device has to answer for the first time."""


class Measuring(AfterDeath):
    """The newest sample, its age, and the offsets that homing found."""

    _sample: Sample | None = None
    _age: int = DROP_TICKS
    _offset: Pair | None = None
    """Of the joints (rad), found by homing; before it, the device file's count."""

    @final
    def _joint_angle(self) -> Pair:
        if self._sample is None:
            return math.nan, math.nan
        first, second = self.file.joints
        offset = self._offset or (first.offset, second.offset)
        shaft = self._sample.shaft_angle
        return (
            first.direction * shaft[0] + offset[0],
            second.direction * shaft[1] + offset[1],
        )

    @final
    def _set_home(self, home: Pair) -> None:
        """Make the next sample's shaft angles the joint angles ``home`` (rad)."""
        shaft = self._fresh_sample().shaft_angle
        first, second = self.file.joints
        self._offset = (
            home[0] - first.direction * shaft[0],
            home[1] - second.direction * shaft[1],
        )

    @final
    def _fresh_sample(self) -> Sample:
        for _ in range(FIRST_SAMPLE_TRIES):
            self._send_zero()
            self.pause()
            sample = self._receive()
            if sample is not None:
                self._sample = sample
                return sample
        raise DeviceError(f"{self.name} does not answer")

    @final
    def _take(self) -> bool:
        """Receive; whether there was a new valid sample."""
        try:
            sample = self._receive()
        except Exception as error:
            if self.state is not State.FAULT:
                self._trip_on(error)
            return False
        if sample is None:
            return False
        self._sample = sample
        return True
