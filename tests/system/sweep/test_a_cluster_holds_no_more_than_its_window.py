"""A sweep gives a cluster a bounded number of runs at a time, as its scheduler counts them."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import pytest

from cosim.reading import FORMS
from cosim.sweep.job import Task
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.work.cluster import UNDER_WAY, DaskPool

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="forks")]
RUNS, CHUNK, WORKERS = 160, 2, 2


def held(dask_scheduler: Any) -> int:
    """What the scheduler has to do: a task that is over is in memory until it is let go."""
    return sum(
        task.state not in {"memory", "released", "forgotten"}
        for task in dask_scheduler.tasks.values()
    )


def test_what_is_under_way_is_bounded_where_it_is_counted() -> None:
    distributed = pytest.importorskip("distributed")
    vary = {"seed": f"1..{RUNS}"}
    sets = ["duration=1/32", "expect=~"]
    plan = plan_of(Request(scenario="single_axis_distributed", vary=vary, sets=sets), FORMS)
    taken = 0

    def tasks() -> Iterator[Task]:
        nonlocal taken
        for number, point in enumerate(plan.points):
            taken += 1
            yield Task(number, point, str(number))

    cluster = distributed.LocalCluster(
        n_workers=WORKERS, threads_per_worker=1, processes=False, dashboard_address=None
    )
    with cluster, distributed.Client(cluster) as client:
        most, numbers = 0, set[int]()
        with DaskPool(plan.job, client, chunk=CHUNK) as pool:
            for result in pool.run(tasks()):
                numbers.add(result.number)
                most = max(most, client.run_on_scheduler(held))
                # Of the runs that were taken, those that nobody has told of yet.
                assert taken - len(numbers) < (UNDER_WAY * WORKERS + 1) * CHUNK
    assert numbers == set(range(RUNS))
    assert 1 < most <= UNDER_WAY * WORKERS
