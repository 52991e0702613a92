"""A sweep in one call, for notebooks and scripts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from cosim.base.arguments import texts_of
from cosim.base.errors import InputError
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
    sample_seed: int | None = None,
    boundary: bool = False,
    start: str | float | None = None,
    out: str | Path | None = None,
    workers: int | None = None,
    scheduler: Any = None,
    timeout: float | None = None,
    follow: Follow | None = None,
) -> SweepOutcome:
    """Run a scenario many times; docs/sweeps.md says what the arguments take.

    ``scenario`` is a name, a file, or one that was loaded and perhaps edited. ``workers`` is
    the number of processes, 0 for this one alone, and ``timeout`` (s) the longest that a run may
    take in them; ``scheduler`` takes their place: the address of Dask's, or a client of it.
    ``follow`` is told how far the sweep is.

    Raises:
        InputError: what is asked for cannot be.
        RunError: no worker comes to life, or the scheduler is gone.
    """
    given = (
        Written(scenario.file, scenario.root, FORMS) if isinstance(scenario, Scenario) else scenario
    )
    request = Request(
        scenario=given,
        sets=texts_of("sets", sets),
        vary=vary or {},
        seeds=seeds,
        expect=expect or {},
        measure=measure or {},
        sample=sample,
        points=points,
        sample_seed=sample_seed,
        boundary=boundary,
        start=start,
    )
    if scheduler is not None and (workers is not None or timeout is not None):
        raise InputError(
            "workers and timeout are for processes of this machine, not for a scheduler's."
        )
    plan = plan_of(request, FORMS)
    pool = None if scheduler is None else DaskPool(plan.job, scheduler)
    folder = None if out is None else Path(out)
    return run_sweep(plan, folder, workers=workers, pool=pool, follow=follow, timeout=timeout)
