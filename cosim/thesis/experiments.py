"""Runs many scenarios and trials at once, in processes of their own."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosim.base.errors import CohapticError

Task = tuple[Callable[..., Any], tuple[Any, ...]]
"""A function that other processes can import, and its arguments."""


@dataclass(frozen=True, slots=True)
class Ran:
    """One scenario's run: its folder and summary, or the sentence that says why there is none."""

    name: str
    folder: Path
    summary: Mapping[str, Any]
    failure: str = ""


def run_all(
    scenarios: Mapping[str, tuple[str, Sequence[str]]],
    out: Path,
    *,
    workers: int | None = None,
    told: Callable[[Ran], None] | None = None,
) -> dict[str, Ran]:
    """Run scenarios (name -> file and ``--set`` overrides) into ``out/<name>``.

    Args:
        scenarios: what to run, by the name that its folder gets.
        out: parent of the run folders.
        workers: processes at a time; as many as there are processors by default.
        told: called with each run as it ends, in the order in which they end.

    Returns:
        The runs by name, in the order of ``scenarios``.
    """
    found: dict[str, Ran] = {}
    with _pool(workers, len(scenarios)) as pool:
        waiting: list[Future[Ran]] = [
            pool.submit(run_one, name, file, tuple(sets), out / name, page=True)
            for name, (file, sets) in scenarios.items()
        ]
        for future in as_completed(waiting):
            ran = future.result()
            found[ran.name] = ran
            if told is not None:
                told(ran)
    return {name: found[name] for name in scenarios}


def in_parallel(tasks: Sequence[Task], workers: int | None = None) -> list[Any]:
    """Call each task's function in another process; what they return, in their order.

    Raises:
        CohapticError: what a task raised.
    """
    with _pool(workers, len(tasks)) as pool:
        waiting = [pool.submit(function, *arguments) for function, arguments in tasks]
        return [future.result() for future in waiting]


def run_one(
    name: str, file: str, sets: tuple[str, ...], folder: Path, *, page: bool = False
) -> Ran:
    """Run one scenario into a folder, with its page or without; a failure is told, not raised."""
    from cosim.analysis import load_tuned
    from cosim.run import run_scenario

    try:
        finished = run_scenario(
            load_tuned(bundled_file(file), (), sets), folder, figure=False, page=page
        )
    except CohapticError as error:
        return Ran(name, folder, {}, str(error))
    failure = str(finished.error) if finished.error is not None else ""
    return Ran(name, folder, finished.summary.content, failure)


def bundled_file(name: str) -> str:
    """The bundled scenario of that name, whatever else is called so in the working folder."""
    from cosim.scenario.source.find import bundled_folder

    return str(bundled_folder() / f"{name}.yaml") if name.startswith("thesis/") else name


def _pool(workers: int | None, tasks: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(min(workers or _processors(), max(tasks, 1)), mp_context=context)


def _processors() -> int:
    """Processors that this process may use."""
    try:
        return len(os.sched_getaffinity(0))
    except AttributeError:  # Windows and macOS
        return os.cpu_count() or 1
