"""Runs from Python: ``cohaptic.run`` and ``cohaptic.resume``."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from cosim.base.arguments import texts_of
from cosim.base.component import Component
from cosim.continuation.continued import Continuation
from cosim.continuation.origin import Origin
from cosim.master.run.execution.loop import Progress
from cosim.reading import load, scenario_of
from cosim.record.reader import SCENARIO_FILE
from cosim.run import Finished, run_scenario
from cosim.scenario import Scenario


def run(
    scenario: str | Path | Scenario,
    out: str | Path | None = None,
    *,
    sets: Sequence[str] = (),
    components: Mapping[str, Component] | None = None,
    snapshots: Sequence[str] = (),
    figure: bool = True,
    page: bool | None = None,
    progress: Progress | None = None,
) -> Finished:
    """Run a scenario into a folder: ``out``, or the next free ``runs/<scenario>-<n>``.

    It runs in this process: an FMU that calls ``exit`` ends it with a sentence and status 1, one
    that crashes without a word, unless its component says ``isolate: process``.

    Args:
        scenario: a name, a file, or what ``load`` and ``edit`` return.
        out: the folder, new or empty.
        sets: overrides as ``--set`` takes them, of a name or a file.
        components: components that exist already, by name, in place of those that the scenario
            would make.
        snapshots: times (``"2.5 s"``) at which the state is left in the folder, for ``resume``.
        figure: whether the overview is drawn.
        page: whether the page is made; as the figure where nothing is said.
        progress: told the ticks done and the wall time (s), a few times a second.

    Raises:
        InputError: something cannot be used; no folder is left behind.
        RunError: the record could not be begun.
        TypeError: an argument is not what it has to be.
    """
    scenario = scenario_of(scenario, sets)
    times = texts_of("snapshots", snapshots)
    return run_scenario(
        scenario,
        None if out is None else Path(out),
        execute=Continuation(_say, None, times) if times else None,
        figure=figure,
        page=page,
        progress=progress,
        instances=components,
    )


def resume(
    folder: str | Path,
    time: str,
    out: str | Path | None = None,
    *,
    duration: str | None = None,
    figure: bool = True,
    page: bool | None = None,
) -> Finished:
    """Go on from a time of an earlier run, with its scenario; the new record is whole.

    From the snapshot of that time where there is one, else everything is computed again from tick
    0. ``duration`` may differ from the earlier run's.
    It runs in this process, as ``run`` does.

    Raises:
        InputError: there is no such run or time, or it cannot be gone on from.
        RunError: what both runs have is not equal; the message names the first difference.
    """
    earlier = Path(folder)
    sets = [] if duration is None else [f"duration={duration}"]
    scenario = load(earlier / SCENARIO_FILE, sets=sets)
    return run_scenario(
        scenario,
        None if out is None else Path(out),
        execute=Continuation(_say, Origin(earlier, time)),
        figure=figure,
        page=page,
    )


def _say(sentence: str) -> None:
    sys.stderr.write(f"{sentence}\n")
