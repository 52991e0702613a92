"""Runs point after point in this process: simulations stay assembled, FMUs loaded."""

from __future__ import annotations

from dataclasses import replace
from types import TracebackType

from cosim.base.errors import CohapticError, InputError
from cosim.scenario import Scenario
from cosim.sweep.job import Job, RunResult, Task
from cosim.sweep.work.traces import Traces
from cosim.sweep.work.variants import Variants
from cosim.sweep.work.warm import Warm

WARM = 4
"""Plans that are kept ready. Delays of no, one and more samples give three."""


class PointRunner:
    """Runs the points of a sweep; a context manager that frees every FMU at the end."""

    def __init__(self, job: Job, traces: Traces | None = None) -> None:
        """``traces`` are told what each run does."""
        self._job = job
        self._traces = traces or Traces()
        self._variants = Variants(job)
        self._warm: list[Warm] = []
        self._done = 0

    def run(self, task: Task) -> RunResult:
        """Run one point; whatever becomes of it is in the result."""
        self._done += 1
        every = self._job.check_every
        try:
            scenario = self._variants.scenario(task.point)
            result = self._run(self._warm_for(scenario), task)
            if every and self._done % every == 1 % every and result.status in {"good", "failed"}:
                return self._checked(task, result)
        except CohapticError as error:
            status = "refused" if isinstance(error, InputError) else "error"
            return RunResult(task.number, task.key, task.point, status, str(error))
        return result

    def close(self) -> None:
        """Free everything."""
        while self._warm:
            self._let_go(self._warm.pop())

    def __enter__(self) -> PointRunner:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _run(self, warm: Warm, task: Task) -> RunResult:
        try:
            return warm.run(task)
        finally:
            if warm.is_lost:
                self._warm.remove(warm)
                self._let_go(warm)

    def _warm_for(self, scenario: Scenario) -> Warm:
        for warm in self._warm:
            if warm.turn_to(scenario):
                self._warm.remove(warm)
                self._warm.insert(0, warm)
                return warm
        while len(self._warm) >= WARM:
            self._let_go(self._warm.pop())
        self._warm.insert(0, self._take(scenario))
        return self._warm[0]

    def _take(self, scenario: Scenario) -> Warm:
        place = self._traces.take()
        try:
            return Warm(self._job, scenario, place)
        except CohapticError:
            self._traces.give_back(place)
            raise

    def _let_go(self, warm: Warm) -> None:
        warm.close()
        self._traces.give_back(warm.whereabouts)

    def _checked(self, task: Task, result: RunResult) -> RunResult:
        """The result, if a run from nothing has the same rows; else what is wrong."""
        rows = self._warm[0].digest()
        cold = self._take(self._variants.anew(task.point))
        try:
            again = cold.run(task)
            is_equal = cold.digest() == rows and again.measures == result.measures
        finally:
            self._let_go(cold)
        if is_equal:
            return replace(result, checked=True)
        return RunResult(
            task.number,
            task.key,
            task.point,
            "error",
            "A run from nothing has other values than the same run in a process that had run other "
            "points before: one of its components keeps something from run to run.",
        )
