"""How far a sweep is and how long it still takes, by a clock that the test turns."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cosim.cli.sweep import lines_of
from cosim.reading import FORMS
from cosim.sweep.job import RunResult, Task
from cosim.sweep.planning.plan import Request, SweepPlan, plan_of
from cosim.sweep.sweep import Step, run_sweep


class Turned:
    """Workers and clock in one: a run takes what its cost says, and nothing is computed."""

    def __init__(self, costs: list[float], last: int | None = None) -> None:
        self.time, self.costs, self.last = 1000.0, costs, last
        self.run_numbers: list[int] = []

    def __call__(self) -> float:
        return self.time

    def __enter__(self) -> Turned:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def run(self, tasks: Iterable[Task]) -> Iterator[RunResult]:
        for task in tasks:
            if task.number == self.last:
                raise KeyboardInterrupt
            self.time += self.costs[task.number]
            self.run_numbers.append(task.number)
            yield RunResult(task.number, task.key, task.point, "good")


def planned(values: Any) -> SweepPlan:
    return plan_of(Request(scenario="single_axis_distributed", vary={"duration": values}), FORMS)


def steps_of(plan: SweepPlan, workers: Turned, out: Path) -> list[tuple[float, Step]]:
    """The time and what was told, at each step."""
    told: list[tuple[float, Step]] = []

    def follow(step: Step) -> None:
        told.append((workers.time, step))

    run_sweep(plan, out, pool=workers, follow=follow, theory=False, clock=workers)
    return told


def worst(told: list[tuple[float, Step]], from_share: float) -> float:
    """How far the estimate is off at most, as a share of the whole time, after some of the runs."""
    begun, end = told[0][0], told[-1][0]
    return max(
        abs(step.left - (end - at)) / (end - begun)
        for at, step in told
        if step.left is not None and step.done >= from_share * step.total
    )


def test_before_the_first_run_nothing_is_said_of_the_end(tmp_path: Path) -> None:
    told = steps_of(planned([1, 2]), Turned([1.0, 2.0]), tmp_path / "out")
    assert [step.left is None for _, step in told] == [True, False, False]
    assert told[-1][1].left == 0
    assert [(step.done, step.total) for _, step in told] == [(0, 2), (1, 2), (2, 2)]


def test_points_that_simulate_longer_are_counted_as_longer(tmp_path: Path) -> None:
    """From the shortest to a hundred times that: by the number of runs it would be off by half."""
    durations = [0.01 * 1.1**n for n in range(50)]
    told = steps_of(planned(durations), Turned([7.0 * d for d in durations]), tmp_path / "out")
    assert worst(told, 0.0) < 1e-9


def test_units_of_the_duration_do_not_matter(tmp_path: Path) -> None:
    told = steps_of(planned(["10 ms", "1000 ms"]), Turned([0.01, 1.0]), tmp_path / "out")
    assert told[1][1].left == pytest.approx(1.0)


def test_unequal_costs_that_nobody_can_know_are_met_on_the_way(tmp_path: Path) -> None:
    """One run in four takes ten times as long: within a tenth after a quarter of the runs."""
    plan = plan_of(Request(scenario="single_axis_distributed", seeds=100), FORMS)
    told = steps_of(plan, Turned([10.0 if n % 4 == 0 else 1.0 for n in range(100)]), tmp_path / "o")
    assert worst(told, 0.25) < 0.1


def test_what_was_known_before_is_no_pace(tmp_path: Path) -> None:
    """Gone on with, the time left is that of what is left, at the pace of now."""
    plan = plan_of(Request(scenario="single_axis_distributed", seeds=100), FORMS)
    with pytest.raises(KeyboardInterrupt):
        steps_of(plan, Turned([1.0] * 100, last=60), tmp_path / "out")
    again = Turned([5.0] * 100)
    told = steps_of(plan, again, tmp_path / "out")
    assert again.run_numbers == list(range(60, 100))
    assert (told[0][1].done, told[0][1].left) == (60, None)
    assert worst(told, 0.0) < 1e-9


@settings(max_examples=6, deadline=None)
@given(values=st.lists(st.sampled_from([0.1, 0.2, 0.3]), min_size=1, max_size=6))
def test_points_that_are_alike_are_one_run(
    tmp_path_factory: pytest.TempPathFactory, values: list[float]
) -> None:
    plan, out = planned(values), tmp_path_factory.mktemp("sweep") / "out"
    workers = Turned([1.0] * len(values))
    told = steps_of(plan, workers, out)
    assert len(workers.run_numbers) == len(set(values)) == told[-1][1].done == told[-1][1].total
    outcome = run_sweep(plan, out, pool=Turned([]), theory=False)
    assert [each.number for each in outcome.results] == list(range(len(values)))
    assert outcome.reused == len(values)
    fresh = run_sweep(plan, out.with_name("fresh"), pool=Turned([1.0] * len(values)), theory=False)
    assert fresh.reused == 0, "of points that are alike none was known before"


def test_a_log_gets_a_line_a_minute(capsys: pytest.CaptureFixture[str]) -> None:
    show = lines_of("box")
    for second in range(0, 200, 7):
        show(Step(second, 200, 3, float(second), 200.0 - second))
    assert capsys.readouterr().err.splitlines() == [
        "box: 63 of 200 · 3 not good · 2 min left",
        "box: 126 of 200 · 3 not good · 74 s left",
        "box: 189 of 200 · 3 not good · 11 s left",
    ]
