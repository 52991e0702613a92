"""Runs that begin in the middle: where one has ended, others begin, as often as wanted."""

from __future__ import annotations

from cosim.base.errors import InputError
from cosim.master.assembly.assemble import Assembly
from cosim.master.run import branch_point
from cosim.master.run.branch_point import BranchPoint
from cosim.master.run.execution.life_cycle import LifeCycle


class Branching:
    """The place in a simulation where runs part, if it has one."""

    def __init__(self, cycle: LifeCycle) -> None:
        self._cycle = cycle
        self._origin: BranchPoint | None = None

    @property
    def has_begun(self) -> bool:
        """Whether there is such a place: then nothing is started or closed from run to run."""
        return self._origin is not None

    def mark(self) -> None:
        """It is here.

        Raises:
            InputError: a component's state cannot be kept.
            RunError: a component failed.
        """
        with self._cycle.guarding():
            self._origin = branch_point.mark(*self._cycle.state)

    def go_back(self, assembly: Assembly) -> None:
        """Be there, with what channels of ``assembly`` do from then on.

        Raises:
            InputError: there is no such place, or components have other values.
            RunError: a component does not take its state back.
        """
        if self._origin is None:
            raise InputError("No run of this simulation has ended where others could begin.")
        branch_point.check_branch(self._origin, assembly)
        self._cycle.take(assembly)
        with self._cycle.guarding():
            branch_point.go_back(self._origin, *self._cycle.state)
