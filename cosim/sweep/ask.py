"""A sweep in one call, for notebooks and scripts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cosim.reading import FORMS
from cosim.scenario import Scenario
from cosim.scenario.load import Written
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.sweep import Follow, SweepOutcome, run_sweep
from cosim.sweep.work.cluster import DaskPool


def sweep(
    scenario: str | Path | Scenario,
    vary: Mapping[str, Any] | None = None,
    *,
    seeds: int | None = None,
    sets: Sequence[str] = (),
    expect: Mapping[str, Any] | None = None,
    measure: Mapping[str, str | Sequence[str]] | None = None,
    sample: str = "grid",
    points: int | None = None,
    boundary: bool = False,
    start: str | float | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
    scheduler: Any = None,
    follow: Follow | None = None,
) -> SweepOutcome:
    """Run a scenario many times; docs/sweeps.md says what the arguments take.

    ``scenario`` is a name, a file, or one that was loaded and perhaps edited. ``scheduler`` is the
    address of Dask's, or a client of it. ``follow`` is told how far the sweep is.

    Raises:
        InputError: what is asked for cannot be.
        RunError: no worker comes to life, or the scheduler is gone.
    """
    given = (
        Written(scenario.file, scenario.root, FORMS) if isinstance(scenario, Scenario) else scenario
    )
    request = Request(
        scenario=given,
        sets=sets,
        vary=vary or {},
        seeds=seeds,
        expect=expect or {},
        measure=measure or {},
        sample=sample,
        points=points,
        boundary=boundary,
        start=start,
    )
    plan = plan_of(request, FORMS)
    pool = None if scheduler is None else DaskPool(plan.job, scheduler)
    folder = None if out is None else Path(out)
    return run_sweep(plan, folder, workers=workers, pool=pool, follow=follow)
