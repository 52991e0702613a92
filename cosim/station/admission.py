"""The compiled judge of what comes over a link: one call in place of NumPy's eight.

With cold caches, as in a paced loop, each NumPy call costs several microseconds.
"""

from __future__ import annotations

import ctypes
from typing import Any

import numpy as np

from cosim.link.stream.admission import Admission, Plausibility
from cosim.link.stream.bundle import Floats, PacketBundle
from cosim.master.kernel.native import library
from cosim.master.kernel.structures import AdmissionStruct

_VERDICTS = tuple(Plausibility)
_REMEMBERED = 64


class CompiledAdmission:
    """What :class:`~cosim.link.stream.admission.Admission` does, bit for bit."""

    def __init__(self, bundle: PacketBundle) -> None:
        plain = Admission(bundle)
        whole = np.zeros(bundle.size, dtype=np.int64)
        whole[plain.whole] = 1
        reference: Floats = np.zeros(bundle.size)
        # The structure holds addresses alone, so the arrays are kept here.
        self._kept: tuple[Any, ...] = (plain.minimum, plain.maximum, plain.step, whole, reference)
        self._struct = AdmissionStruct(bundle.size, *(each.ctypes.data for each in self._kept))
        self._where = ctypes.addressof(self._struct)
        self._admit: Any = library().link_admit
        self._scratch: Floats = np.zeros(bundle.size)
        self._addresses: dict[int, tuple[int, Floats]] = {}
        """Of arrays seen before, which come again and again, by identity."""

    def in_range(self, values: Floats) -> bool:
        """Whether every value is finite, within its range, and whole where it is an integer."""
        return self.judge(values, 0, self._scratch, newest=False) is Plausibility.FITS

    def judge(self, values: Floats, ticks: int, out: Floats, *, newest: bool) -> Plausibility:
        """See :meth:`~cosim.link.stream.admission.Admission.judge`; arrays are contiguous."""
        known = self._addresses
        source = known.get(id(values)) or self._remember(values)
        target = known.get(id(out)) or self._remember(out)
        verdict: int = self._admit(self._where, source[0], ticks, target[0], newest)
        return _VERDICTS[verdict]

    def _remember(self, array: Floats) -> tuple[int, Floats]:
        if len(self._addresses) >= _REMEMBERED:
            self._addresses.clear()
        found = (int(array.ctypes.data), array)
        self._addresses[id(array)] = found
        return found
