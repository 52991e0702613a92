"""One scenario through ``cohaptic run``: read as what it is, then run in a child or paced."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.base.errors import InputError
from cosim.cli.support.console import Console, ended
from cosim.cli.support.devices import refuse_without_devices
from cosim.cli.support.pace import pace_of
from cosim.cli.support.page import live_page, scene_of

if TYPE_CHECKING:
    from cosim.base.component import Component
    from cosim.cli.support.pace import Policy
    from cosim.master.run.execution.loop import Progress
    from cosim.realtime.paced_run import PacedRun
    from cosim.run import Execute, Finished
    from cosim.scenario import Scenario


@dataclass(frozen=True, slots=True)
class RunOptions:
    """The options of ``cohaptic run`` that say how a scenario is read and run."""

    overlays: tuple[str, ...] = ()
    sets: tuple[str, ...] = ()
    duration: str | None = None
    stop_time: str | None = None
    step_size: str | None = None
    snapshots: tuple[str, ...] = ()
    origin: str | None = None
    figure: bool = True
    report: bool | None = None
    realtime: bool = False
    live: bool = False
    foxglove: bool = False
    live_at: str | None = None
    on_miss: Policy | None = None
    cpu: int | None = None
    enable_output: bool = False
    yes: bool = False
    dead_man: str | None = None


def read_one(written: str | None, options: RunOptions, say: Callable[[str], None]) -> Scenario:
    """The scenario that is to run: from a file, an FMU, a system, or an earlier run.

    Raises:
        InputError: it cannot be used, or an option is not for it.
    """
    from cosim.cli.ssp.system import scenario_of_system
    from cosim.cli.support.fmu.alone import is_fmu, scenario_of_fmu
    from cosim.continuation.origin import scenario_to_run
    from cosim.reading import load
    from cosim.ssp.package import is_system

    alone, system = is_fmu(written), is_system(written)
    if not (alone or system) and (options.stop_time or options.step_size):
        raise InputError("--stop-time and --step-size are for an FMU in place of a scenario.")
    if system and options.step_size:
        raise InputError(
            "--step-size is for a single FMU; --set components.NAME.rate=… changes one."
        )
    if (alone or system) and (options.overlays or options.duration):
        raise InputError("An FMU or a system runs with --stop-time and --set.")
    found = scenario_to_run(
        written,
        options.origin,
        changed=bool(options.overlays or options.sets),
        special=bool(options.origin or options.snapshots),
        realtime=options.realtime,
    )
    sets = options.sets
    if options.duration is not None:
        sets = (*sets, f"duration={options.duration}")
    scenario = (
        scenario_of_fmu(
            found, stop_time=options.stop_time, step_size=options.step_size, sets=sets, say=say
        )
        if alone
        else scenario_of_system(found, stop_time=options.stop_time, sets=sets, say=say)
        if system
        else load(found, options.overlays, sets)
    )
    refuse_without_devices(
        scenario,
        enable_output=options.enable_output,
        yes=options.yes,
        dead_man=options.dead_man,
    )
    return scenario


def run_one(
    scenario: Scenario,
    out: Path | None,
    options: RunOptions,
    say: Callable[[str], None],
    instances: Mapping[str, Component] | None = None,
) -> Finished:
    """Run it into ``out``, or into the next free ``runs/<scenario>-<n>``.

    ``instances`` are components of this process, by name, of a run that is paced.

    Raises:
        InputError, RunError: as ``cosim.run.run_scenario``.
    """
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.cli.support.run.child import run_in_child
    from cosim.run import run_scenario

    paced = _devices(scenario, options, say)
    console = Console() if sys.stderr.isatty() and paced is not None else None
    if paced is not None:
        from cosim.base.system.grants import clock_nanosleep
        from cosim.realtime.pacing import DeadlinePacer

        pace = pace_of(scenario, on_miss=options.on_miss, cpu=options.cpu)
        tick = 1 / scenario.base_rate
        paced.cpu = pace.cpu
        paced.pacer = DeadlinePacer(tick_seconds=tick, policy=pace.on_miss, sleep=clock_nanosleep())
        paced.console = console
        paced.about = scene_of
    page = live_page(
        live=options.live,
        live_at=options.live_at,
        wanted=str(os.getpid()),
        foxglove=options.foxglove,
    )
    with page, _progress(scenario) if paced is None else ended(console) as progress:
        judge = DeviceJudge(realtime=options.realtime, output=options.enable_output)
        if paced is None:
            return run_in_child(
                scenario,
                out,
                progress=progress,
                execute=_execution(options, say),
                figure=options.figure,
                page=options.report,
                judge=judge,
                say=say,
            )
        return run_scenario(
            scenario,
            out,
            progress=progress,
            execute=paced,
            deadlines=paced.statistics,
            figure=options.figure,
            page=options.report,
            instances=instances,
            judge=judge,
            say=say,
        )


def _execution(options: RunOptions, say: Callable[[str], None]) -> Execute | None:
    """How a run without a pace is run.

    Raises:
        InputError: a page is wanted beside snapshots or an origin.
    """
    from cosim.continuation.continued import continuation

    if not options.live and not options.foxglove:
        return continuation(say, options.origin, options.snapshots)
    if options.origin is not None or options.snapshots:
        asked = "--live" if options.live else "--foxglove"
        raise InputError(f"{asked} cannot go with --snapshot or --from; leave it out.")
    from functools import partial

    from cosim.live.tee import run_watched

    return partial(run_watched, starter=os.getpid())


def _devices(
    scenario: Scenario, options: RunOptions, say: Callable[[str], None]
) -> PacedRun | None:
    """Say what holds for this run's devices; what paces it, with ``--realtime``."""
    realtime = options.realtime
    if not realtime and all(part.kind != "device" for part in scenario.components.values()):
        return None
    from cosim.cli.support.devices import device_session

    device_session(enable_output=options.enable_output, yes=options.yes, dead_man=options.dead_man)
    if not realtime:
        return None
    from cosim.realtime.paced_run import PacedRun

    return PacedRun(say=say)


@contextmanager
def _progress(scenario: Scenario) -> Generator[Progress | None]:
    """A bar on a terminal's stderr with the simulated time and the real-time factor."""
    if not sys.stderr.isatty():
        yield None
        return
    from cosim.cli.support.terminal.bar import progress_bar

    rate = float(scenario.base_rate)
    end = scenario.ticks / rate
    with progress_bar(scenario.name) as bar:
        task = bar.add_task("", total=scenario.ticks, note="")

        def show(ticks: int, wall_time: float) -> None:
            factor = ticks / rate / wall_time if wall_time else 0.0
            note = f"{ticks / rate:.1f} of {end:g} s · {factor:.3g} × real time"
            bar.update(task, completed=ticks, note=note, refresh=True)

        yield show
