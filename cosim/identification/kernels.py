"""Smoothing with one short kernel: angles become rates and accelerations, held torque its mean.

The kernel is a Gaussian sharpened so that its pass band is flat to the sixth order,
H(w) = exp(-x) (1 + x + x^2/2) with x = (s w)^2/2; it, its derivatives and its integral are known in
closed form. What both sides of an equation of motion are smoothed with changes nothing in it, so
torque and friction go through the same kernel; a torque is integrated as it was held, exactly, and
with any delay.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np
from numpy.polynomial.hermite_e import hermeval

from cosim.identification.five_bar import Array

REACH = 8.0
"""Standard deviations after which the kernel is nothing, its derivatives included."""
_SHARPENED = ((0, 1.0), (2, -0.5), (4, 0.125))
"""The kernel as derivatives of a Gaussian: order, and weight in powers of s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Kernel:
    """``width`` is the standard deviation s (s), ``tick`` the sampling period (s)."""

    width: float
    tick: float

    @property
    def reach(self) -> int:
        """Ticks on either side of a row that have a part in it."""
        return int(np.ceil(REACH * self.width / self.tick)) + 1

    def smooth(self, samples: Array, derivative: int = 0) -> Array:
        """Samples (rows, columns), or their derivative, shape (rows - 2 reach, columns)."""
        at = np.arange(-self.reach, self.reach + 1) * self.tick
        return _along(samples, self.tick * self._derived(at, derivative))

    def smooth_held(self, samples: Array, delay: float = 0.0) -> Array:
        """What was held from each row to the next, ``delay`` seconds late; shape as ``smooth``."""
        at = np.arange(-self.reach, self.reach + 1) * self.tick - delay
        return _along(samples, self._integrated(at) - self._integrated(at - self.tick))

    def _derived(self, at: Array, derivative: int) -> Array:
        """The kernel's derivative (1/s^(1 + derivative)) at times (s)."""
        total = np.zeros_like(at)
        for order, weight in _SHARPENED:
            total += weight * self.width**order * self._gaussian(at, order + derivative)
        return total

    def _integrated(self, at: Array) -> Array:
        """The kernel's integral from minus infinity."""
        special: Any = import_module("scipy.special")
        total: Array = np.asarray(special.ndtr(at / self.width), dtype=np.float64)
        for order, weight in _SHARPENED[1:]:
            total += weight * self.width**order * self._gaussian(at, order - 1)
        return total

    def _gaussian(self, at: Array, derivative: int) -> Array:
        scaled = at / self.width
        bell = np.exp(-(scaled**2) / 2) / (self.width * np.sqrt(2 * np.pi))
        polynomial = np.zeros(derivative + 1)
        polynomial[derivative] = (-1.0) ** derivative
        return bell * hermeval(scaled, polynomial) / self.width**derivative


def _along(samples: Array, weights: Array) -> Array:
    """Each column convolved; weight i is that of the sample i ticks before the last that counts."""
    return np.stack([np.convolve(column, weights, "valid") for column in samples.T], axis=1)
