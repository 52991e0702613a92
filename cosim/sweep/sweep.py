"""A sweep from its plan to its results: what is known already is not run again."""

from __future__ import annotations

import importlib
import json
import sys
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from cosim.base.errors import InputError
from cosim.sweep.boundary import Place, refine
from cosim.sweep.job import RunResult, Task
from cosim.sweep.planning.plan import SweepPlan
from cosim.sweep.results.content import Contents
from cosim.sweep.results.store import ResultStore, next_folder
from cosim.sweep.theory import is_stable, radii
from cosim.sweep.work.pool import LocalPool
from cosim.sweep.work.runner import PointRunner
from cosim.sweep.work.variants import Variants
from cosim.sweep.work.warm import Warm


class Workers(Protocol):
    """Runs tasks; results come in any order."""

    def run(self, tasks: Iterable[Task]) -> Iterator[RunResult]:
        """The results as they come."""
        ...


@dataclass(frozen=True, slots=True)
class Step:
    """How far a sweep is; points that are alike are one run."""

    done: int
    """Runs that there is a result of."""
    total: int
    failed: int
    seconds: float
    """Since the first run of this time."""
    left: float | None
    """Time to the end at the pace so far (s); ``None`` before there is one.

    The pace is that of simulated time, where the points differ in it, and of this time alone.
    """


Follow = Callable[[Step], None]
"""Told after each run how far the sweep is."""


@dataclass(frozen=True, slots=True, repr=False)
class SweepOutcome:
    """What came out of a sweep.

    ``results`` has one entry for each point that was run, by number; ``theory`` the spectral radius
    of every point where the theory knows the loop; ``verdicts`` what each point of a boundary is.
    """

    plan: SweepPlan
    folder: Path
    results: tuple[RunResult, ...]
    theory: tuple[float, ...] | None = None
    verdicts: Mapping[int, bool] | None = None
    reused: int = 0
    """Results that were there before."""

    @property
    def failures(self) -> list[RunResult]:
        """Runs that are not good."""
        return [result for result in self.results if not result.is_good]

    def to_dataframe(self) -> Any:
        """A pandas table: a row a run, a column a variable, measure or verdict.

        Raises:
            InputError: pandas is not installed.
        """
        return _shown("frames").to_dataframe(self)

    def to_xarray(self) -> Any:
        """An xarray dataset over the variables, where the points are a grid.

        Raises:
            InputError: xarray is not installed, or the points are a sample.
        """
        return _shown("frames").to_xarray(self)

    def plot(self, file: str | Path | None = None) -> Path:
        """Draw a map, a curve or a histogram, into the sweep's folder unless told otherwise."""
        place = self.folder / "sweep.png" if file is None else Path(file)
        _shown("figures").draw_sweep(self, place)
        return place

    def __repr__(self) -> str:
        return str(_shown("frames").outline(self))

    def _repr_html_(self) -> str:
        import html

        return f"<pre>{html.escape(repr(self))}</pre>"

    @property
    def disagreements(self) -> int | None:
        """Runs whose verdict is not what the theory says; ``None`` where it says nothing."""
        if self.theory is None or not any(result.passed for result in self.results):
            return None
        return sum(each.is_good != is_stable(self.theory[each.number]) for each in self.results)


def _shown(how: str) -> Any:
    """What shows an outcome; it stands above this module, which knows it by name alone."""
    return importlib.import_module(f"cosim.sweep.results.{how}")


def run_sweep(
    plan: SweepPlan,
    folder: Path | None = None,
    *,
    workers: int | None = None,
    pool: AbstractContextManager[Workers] | None = None,
    follow: Follow | None = None,
    timeout: float | None = None,
    theory: bool | None = None,
    clock: Callable[[], float] = time.monotonic,
) -> SweepOutcome:
    """Run what is not known yet.

    ``workers`` is the number of processes; 0 runs in this one, without protection from crashes.
    ``pool`` takes their place. ``timeout`` (s) is the longest that one run may take. ``theory``:
    whether the theory is asked; without a word it is where growth is judged or a boundary sought.
    ``clock`` (s) is what ``follow`` is told the time by.

    Raises:
        InputError: the scenario, an expectation or the folder cannot be used.
        RunError: no worker comes to life.
    """
    if workers is not None and not hasattr(workers, "__index__"):
        raise InputError(f"workers: {workers!r} is no whole number of processes.")
    if workers is not None and workers < 0:
        raise InputError(f"workers: {workers} processes are none; 0 runs in this one.")
    if timeout is not None and not timeout > 0:
        raise InputError(f"timeout: {timeout:g} s is no time that a run may take.")
    if timeout is not None and (workers == 0 or sys.platform == "win32"):
        raise InputError("timeout: only a run in another process can be ended.")
    variants = Variants(plan.job)
    first = variants.scenario(plan.points[0])
    with closing(Warm(plan.job, first)) as base:
        contents = Contents(plan.job, base.assembly)
    place = folder or next_folder(plan.name)
    if theory is None:
        theory = plan.boundary or "growth" in json.dumps(plan.expectations)
    expected = radii(variants, plan.points) if theory else None
    with ResultStore(place) as store:
        store.describe(_description(plan, contents.structure))
        keys = [contents.key(point) for point in plan.points]
        runs = _Runs(plan, keys, store, follow, clock)
        with pool or _local(plan, len(runs.missing(range(len(keys)))), workers, timeout) as used:
            verdicts = None
            if plan.boundary:
                verdicts = runs.boundary(used, expected)
            else:
                runs.all(used, range(len(plan.points)))
    return SweepOutcome(
        plan=plan,
        folder=place,
        results=tuple(runs.results()),
        theory=None if expected is None else tuple(expected),
        verdicts=verdicts,
        reused=runs.reused,
    )


class _Runs:
    """The points of a sweep by number, and what is known of them."""

    def __init__(
        self,
        plan: SweepPlan,
        keys: Sequence[str],
        store: ResultStore,
        follow: Follow | None,
        clock: Callable[[], float],
    ) -> None:
        self._plan, self._keys, self._store = plan, keys, store
        self._before = frozenset(store.known)
        self._follow, self._clock = follow, clock
        self._began: float | None = None
        self._asked: set[int] = set()
        self._total = self._done = self._failed = 0
        self._ran = self._left = 0.0
        """Simulated time (s; or runs, where all are alike) run this time, and to be run."""
        self.reused = 0

    def missing(self, numbers: Iterable[int]) -> list[int]:
        """Those that have to be run; of equal points one."""
        found: dict[str, int] = {}
        for number in numbers:
            if self._keys[number] not in self._store.known:
                found.setdefault(self._keys[number], number)
        return list(found.values())

    def all(self, workers: Workers, numbers: Sequence[int]) -> None:
        """Have results of all these points."""
        missing = self.missing(numbers)
        self._asked.update(numbers)
        self.reused = sum(self._keys[number] in self._before for number in self._asked)
        self._began = self._clock() if self._began is None else self._began
        keys = {self._keys[number] for number in self._asked}
        known = [self._store.known[key] for key in keys if key in self._store.known]
        self._total, self._done = len(keys), len(known)
        self._failed = sum(not result.is_good for result in known)
        self._left = sum(map(self._plan.cost, missing))
        self._tell()
        tasks = (Task(n, self._plan.points[n], self._keys[n]) for n in missing)
        for result in workers.run(tasks):
            self._store.add(result)
            cost = self._plan.cost(result.number)
            self._ran, self._left = self._ran + cost, self._left - cost
            self._done += 1
            self._failed += not result.is_good
            self._tell()

    def boundary(self, workers: Workers, theory: Sequence[float] | None) -> dict[int, bool]:
        """The verdict of every point of the grid; few are run."""
        first, second = self._plan.axes
        shape = len(first.values), len(second.values)

        def number(place: Place) -> int:
            return place[0] * shape[1] + place[1]

        def evaluate(places: Sequence[Place]) -> dict[Place, bool]:
            self.all(workers, [number(place) for place in places])
            return {place: self._result(number(place)).is_good for place in places}

        def seen(place: Place) -> bool:
            return theory is not None and is_stable(theory[number(place)])

        found = refine(shape, evaluate, seen if theory is not None else None)
        return {number(place): good for place, good in found.items()}

    def results(self) -> list[RunResult]:
        """What is known, by number."""
        return [self._result(number) for number in sorted(self._asked) if self._is_known(number)]

    def _is_known(self, number: int) -> bool:
        return self._keys[number] in self._store.known

    def _result(self, number: int) -> RunResult:
        return replace(self._store.known[self._keys[number]], number=number)

    def _tell(self) -> None:
        if self._follow is not None and self._began is not None:
            seconds = self._clock() - self._began
            left = seconds / self._ran * self._left if self._ran else None
            self._follow(Step(self._done, self._total, self._failed, seconds, left))


class _Here:
    """Runs in this process, one after another."""

    def __init__(self, runner: PointRunner) -> None:
        self._runner = runner

    def __enter__(self) -> _Here:
        return self

    def __exit__(self, *_: object) -> None:
        self._runner.close()

    def run(self, tasks: Iterable[Task]) -> Iterator[RunResult]:
        return map(self._runner.run, tasks)


def _local(
    plan: SweepPlan, missing: int, workers: int | None, timeout: float | None
) -> AbstractContextManager[Workers]:
    if workers == 0 or missing == 0 or sys.platform == "win32":
        return _Here(PointRunner(plan.job))
    return LocalPool(plan.job, workers, timeout=timeout)


def _description(plan: SweepPlan, structure: str) -> dict[str, Any]:
    return {
        "sweep": 1,
        "scenario": plan.name,
        "structure": structure,
        "axes": [
            {"name": axis.name, "places": list(axis.places), "unit": axis.unit}
            for axis in plan.axes
        ],
        "points": len(plan.points),
    }
