"""The operations by their numbers, in a program for each set of periods that are due together."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from cosim.master.assembly.clock import Clock
from cosim.master.assembly.plan import Plan, due_together
from cosim.master.kernel.codes import OperationKind
from cosim.master.kernel.operations import Operations
from cosim.master.kernel.structures import KernelStruct, OperationStruct

INITIAL = 0
"""The number of the program of initialisation mode."""

_FIRST, _EVERY = 1, 2

_RUNS = (OperationKind.SET_FLOAT64, OperationKind.GET_FLOAT64, OperationKind.STEP)
"""Kinds of which the kernel does several in one go, where they lie side by side."""
_BYTES = ctypes.sizeof(OperationStruct)


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
        self.early = frozenset(programs[0] + programs[_FIRST])
        """The operations of initialisation mode and of tick 0; the others belong to every tick."""
        self._pattern = (pattern + _EVERY).astype(np.int32)
        ways = np.array([(each.kind, each.version) for each in operations.all], dtype=np.int32)
        self._spans, self._starts = _runs(programs, ways.reshape(-1, 2))
        self._runs: NDArray[np.int64]

    def bind(self, kernel: KernelStruct) -> None:
        """Have the kernel run these programs."""
        self._runs = kernel.operations + _BYTES * self._spans
        kernel.runs = self._runs.ctypes.data
        kernel.program_start = self._starts.ctypes.data
        kernel.pattern = self._pattern.ctypes.data
        kernel.hyperperiod = self.hyperperiod
        kernel.first_program = _FIRST


def _flat(programs: Iterable[Iterable[int]]) -> list[int]:
    return [number for program in programs for number in program]


def _runs(
    programs: list[list[int]], ways: NDArray[np.int32]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The first number of each run and the one behind its last; at which run each program begins.

    ``ways`` has kind and version of each operation.
    """
    lengths = [len(program) for program in programs]
    flat = np.array(_flat(programs), dtype=np.int64)
    begins = np.ones(len(flat), dtype=bool)
    way = ways[flat]
    follows = (np.diff(flat) == 1) & (way[1:] == way[:-1]).all(axis=1)
    begins[1:] = ~(follows & np.isin(way[1:, 0], _RUNS))
    starts = np.cumsum([0, *lengths])
    begins[starts[:-1][starts[:-1] < len(flat)]] = True
    first = np.flatnonzero(begins)
    last = np.append(first[1:], len(flat)) - 1
    spans = np.stack((flat[first], flat[last] + 1), axis=1)
    return spans, np.searchsorted(first, starts).astype(np.int64)
