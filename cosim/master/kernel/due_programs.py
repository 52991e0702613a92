"""The operations by their numbers, in a program for each set of periods that are due together."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.clock import Clock
from cosim.master.assembly.plan import Plan, due_together
from cosim.master.kernel.codes import OperationKind
from cosim.master.kernel.operations import Operations
from cosim.master.kernel.structures import KernelStruct

INITIAL = 0
"""The number of the program of initialisation mode."""

_FIRST, _EVERY = 1, 2

_RUNS = (OperationKind.SET_FLOAT64, OperationKind.GET_FLOAT64, OperationKind.STEP)
"""Kinds of which the kernel does several in one go, where they lie side by side."""


class DuePrograms:
    """All programs behind one another; owns the memory that the kernel has of them."""

    def __init__(self, plan: Plan, clock: Clock, operations: Operations) -> None:
        """Writes the operations of the plan, too."""
        periods = [action.period for action in plan.every] or [1]
        self.hyperperiod = clock.hyperperiod(periods)
        due_sets, pattern = due_together(periods, self.hyperperiod)
        every = [(action.period, operations.numbers_of(action)) for action in plan.every]
        initial = (operations.numbers_of(action, is_initial=True) for action in plan.initial)
        first = (operations.numbers_of(action) for action in plan.first)
        programs = [_flat(initial), _flat(first)]
        programs += [
            _flat(numbers for period, numbers in every if period in due) for due in due_sets
        ]
        self._starts = np.cumsum([0, *map(len, programs)]).astype(np.int64)
        self._flat = np.array(_flat(programs), dtype=np.int32)
        self._pattern = (pattern + _EVERY).astype(np.int32)
        kinds = np.array([operation.kind for operation in operations.all], dtype=np.int32)
        self._lengths = _run_lengths(self._flat, kinds, self._starts)

    def bind(self, kernel: KernelStruct) -> None:
        """Have the kernel run these programs."""
        kernel.program = self._flat.ctypes.data
        kernel.run_length = self._lengths.ctypes.data
        kernel.program_start = self._starts.ctypes.data
        kernel.pattern = self._pattern.ctypes.data
        kernel.hyperperiod = self.hyperperiod
        kernel.first_program = _FIRST


def _flat(programs: Iterable[Iterable[int]]) -> list[int]:
    return [number for program in programs for number in program]


def _run_lengths(
    flat: NDArray[np.int32], kinds: NDArray[np.int32], starts: NDArray[np.int64]
) -> NDArray[np.int32]:
    """Of each number in the programs: how many neighbours of its kind follow it, it included."""
    if not len(flat):
        return flat
    kind = kinds[flat]
    goes_on = np.zeros(len(flat), dtype=bool)
    goes_on[:-1] = (np.diff(flat) == 1) & (kind[1:] == kind[:-1]) & np.isin(kind[:-1], _RUNS)
    ends = starts[1:-1]
    goes_on[ends[(ends > 0) & (ends <= len(flat))] - 1] = False
    last = np.flatnonzero(~goes_on)
    places = np.arange(len(flat))
    return (last[np.searchsorted(last, places)] - places + 1).astype(np.int32)
