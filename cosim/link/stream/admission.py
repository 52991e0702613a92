"""Whether values may be believed: in their range, whole where they must be, no faster than can be.

A key proves who sent a value and not that the value makes sense.
"""

from __future__ import annotations

import sys
from enum import IntEnum
from typing import Protocol

import numpy as np

from cosim.link.stream.bundle import Floats, PacketBundle

LARGEST_VALUE = sys.float_info.max / 2.0
"""What a field without a range may hold: not infinity, and two of them have a difference."""


class Plausibility(IntEnum):
    """What is wrong with values, if anything."""

    FITS = 0
    OUT_OF_RANGE = 1
    JUMP = 2


class PacketJudge(Protocol):
    """Judges the values of one stream; :class:`Admission` says how."""

    def in_range(self, values: Floats) -> bool:
        """Whether every value is finite, within its range, and whole where it is an integer."""
        ...

    def judge(self, values: Floats, ticks: int, out: Floats, *, newest: bool) -> Plausibility:
        """Judge values, and copy them to ``out`` where they fit."""
        ...


EXACT = 2.0**53
"""An integer that travels is no larger: from there on a float64 does not hold every one."""


class Admission:
    """Judges the values of one stream against its ranges and against the values before them."""

    def __init__(self, bundle: PacketBundle) -> None:
        size = bundle.size
        integer = bundle.spread("integer") != 0.0
        largest = np.where(integer, EXACT, LARGEST_VALUE)
        self.minimum: Floats = np.maximum(bundle.spread("minimum"), -largest)
        self.maximum: Floats = np.minimum(bundle.spread("maximum"), largest)
        self.step: Floats = bundle.spread("speed") * float(bundle.tick)
        """Largest change in a base tick."""
        self.whole = np.flatnonzero(integer)
        self._reference: Floats = np.zeros(size)
        self._scratch: Floats = np.zeros(size)
        # Comparisons write into bytes: to look for a 0 there takes a tenth of NumPy's ``all``.
        self._passed = bytearray(2 * size)
        self._above = np.frombuffer(self._passed, dtype=np.bool_, count=size)
        self._below = np.frombuffer(self._passed, dtype=np.bool_, count=size, offset=size)

    def in_range(self, values: Floats) -> bool:
        """Whether every value is finite, within its range, and whole where it is an integer."""
        # A NaN compares false with everything, so both conditions have to hold.
        np.greater_equal(values, self.minimum, out=self._above)
        np.less_equal(values, self.maximum, out=self._below)
        if self._passed.find(0) >= 0:
            return False
        whole = values[self.whole]
        return bool((whole == np.trunc(whole)).all())

    def judge(self, values: Floats, ticks: int, out: Floats, *, newest: bool) -> Plausibility:
        """Judge values ``ticks`` base ticks from the newest before them (0: there are none).

        What fits is copied to ``out``; where it is ``newest``, the next are compared with it.
        """
        if not self.in_range(values):
            return Plausibility.OUT_OF_RANGE
        if ticks:
            np.subtract(values, self._reference, out=self._scratch)
            np.abs(self._scratch, out=self._scratch)
            np.less_equal(self._scratch, self.step * ticks, out=self._below)
            # What was above the minimum in the range check still is.
            if self._passed.find(0) >= 0:
                return Plausibility.JUMP
        if newest:
            np.copyto(self._reference, values)
        np.copyto(out, values)
        return Plausibility.FITS
