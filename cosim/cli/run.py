"""``cohaptic run``: a scenario, its record, its summary and its figure."""

from __future__ import annotations

import os
import sys
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.console import Console, ended
from cosim.cli.support.devices import output_options, refuse_without_devices
from cosim.cli.support.drawings import drawing_options
from cosim.cli.support.pace import miss_options, pace_of, refuse_without_realtime
from cosim.cli.support.page import live_page, page_options, scene_of
from cosim.cli.support.values import OutputFolder

if TYPE_CHECKING:
    from cosim.cli.support.pace import Policy
    from cosim.master.run.simulation import Progress
    from cosim.realtime.paced_run import PacedRun
    from cosim.run import Execute
    from cosim.scenario import Scenario


@click.command("run", cls=JsonCommand)
@click.argument("scenario", required=False)
@click.option(
    "--with",
    "overlays",
    multiple=True,
    metavar="FILE",
    help="Lay another file over the scenario; may be repeated.",
)
@click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="A.B=C",
    help="Change one value, such as channels.lan.round_trip_delay=2; may be repeated.",
)
@click.option("--duration", metavar="TIME", help="Simulated time, instead of the scenario's (s).")
@click.option(
    "--stop-time", metavar="TIME", help="Of an FMU given in place of a scenario: how long to run."
)
@click.option("--step-size", metavar="TIME", help="Of an FMU: how long its steps are.")
@click.option(
    "--out",
    type=OutputFolder(),
    help="Folder for the run; new or empty. [default: runs/<scenario>-<n>]",
)
@click.option(
    "--snapshot",
    "snapshots",
    multiple=True,
    metavar="TIME",
    help="Leave the run's whole state at this time in its folder, for --from; may be repeated.",
)
@click.option(
    "--from",
    "origin",
    metavar="RUN@TIME",
    help="In place of SCENARIO: go on from an earlier run at this time, and compare.",
)
@drawing_options
@click.option("--realtime", is_flag=True, help="Keep pace with the clock, in a process of its own.")
@page_options
@miss_options
@output_options
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def command(
    scenario: str | None,
    overlays: tuple[str, ...],
    sets: tuple[str, ...],
    duration: str | None,
    out: Path | None,
    *,
    stop_time: str | None,
    step_size: str | None,
    snapshots: tuple[str, ...],
    origin: str | None,
    figure: bool,
    report: bool | None,
    realtime: bool,
    live: bool,
    live_at: str | None,
    on_miss: Policy | None,
    cpu: int | None,
    enable_output: bool,
    yes: bool,
    dead_man: str | None,
    as_json: bool,
) -> None:
    """Run SCENARIO, a file or the name of a bundled one, and record it.

    An FMU, or the folder of an unpacked one, runs alone: --stop-time and --step-size as its default
    experiment says unless they are given, and --set VARIABLE=VALUE for its parameters.

    Exit status: 0 good; 1 the run failed, was interrupted, or an expectation was not met;
    2 something that was given cannot be used.

    With --from, the scenario is the one that the earlier run resolved, and only --duration may
    differ. The new record is whole; it fails where both runs should have the same values and have
    not.
    """
    from cosim.cli.ssp.system import scenario_of_system
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.cli.support.child import run_in_child
    from cosim.cli.support.continuation import scenario_to_run
    from cosim.cli.support.devices import say
    from cosim.cli.support.fmu.alone import is_fmu, scenario_of_fmu
    from cosim.reading import load
    from cosim.run import run_scenario
    from cosim.ssp.package import is_system

    refuse_without_realtime(realtime=realtime, on_miss=on_miss, cpu=cpu)
    alone, system = is_fmu(scenario), is_system(scenario)
    if not (alone or system) and (stop_time or step_size):
        raise InputError("--stop-time and --step-size are for an FMU in place of a scenario.")
    if system and step_size:
        raise InputError(
            "--step-size is for a single FMU; --set components.NAME.rate=… changes one."
        )
    if (alone or system) and (overlays or duration):
        raise InputError("An FMU or a system runs with --stop-time and --set.")
    written = scenario_to_run(
        scenario,
        origin,
        changed=bool(overlays or sets),
        special=bool(origin or snapshots),
        realtime=realtime,
    )
    if duration is not None:
        sets = (*sets, f"duration={duration}")
    loaded = (
        scenario_of_fmu(written, stop_time=stop_time, step_size=step_size, sets=sets)
        if alone
        else scenario_of_system(written, stop_time=stop_time, sets=sets, say=say)
        if system
        else load(written, overlays, sets)
    )
    refuse_without_devices(loaded, enable_output=enable_output, yes=yes, dead_man=dead_man)
    paced = _devices(
        loaded, enable_output=enable_output, yes=yes, dead_man=dead_man, realtime=realtime
    )
    console = Console() if sys.stderr.isatty() and paced is not None else None
    if paced is not None:
        from cosim.base.system.grants import clock_nanosleep
        from cosim.realtime.pacing import DeadlinePacer

        pace = pace_of(loaded, on_miss=on_miss, cpu=cpu)
        tick = 1 / loaded.base_rate
        paced.cpu = pace.cpu
        paced.pacer = DeadlinePacer(tick_seconds=tick, policy=pace.on_miss, sleep=clock_nanosleep())
        paced.console = console
        paced.about = scene_of
    page = live_page(live=live, live_at=live_at, wanted=str(os.getpid()))
    with page, _progress(loaded) if paced is None else ended(console) as progress:
        judge = DeviceJudge(realtime=realtime, output=enable_output)
        finished = (
            run_in_child(
                loaded,
                out,
                progress=progress,
                execute=_execution(origin, snapshots, live=live),
                figure=figure,
                page=report,
                judge=judge,
                say=say,
            )
            if paced is None
            else run_scenario(
                loaded,
                out,
                progress=progress,
                execute=paced,
                deadlines=paced.statistics,
                figure=figure,
                page=report,
                judge=judge,
                say=say,
            )
        )
    if as_json:
        import json

        click.echo(json.dumps(finished.summary.content))
    else:
        click.echo(finished.summary.text())
    if finished.summary.content["message"]:
        click.echo(finished.summary.content["message"], err=True)
    sys.exit(finished.summary.status)


def _execution(origin: str | None, snapshots: tuple[str, ...], *, live: bool) -> Execute | None:
    """How a run without a pace is run.

    Raises:
        InputError: a page is wanted beside snapshots or an origin.
    """
    from cosim.cli.support.continuation import continuation
    from cosim.cli.support.devices import say

    if not live:
        return continuation(say, origin, snapshots)
    if origin is not None or snapshots:
        raise InputError("--live cannot go with --snapshot or --from; leave it out.")
    from functools import partial

    from cosim.live.tee import run_watched

    return partial(run_watched, starter=os.getpid())


def _devices(
    scenario: Scenario, *, enable_output: bool, yes: bool, dead_man: str | None, realtime: bool
) -> PacedRun | None:
    """Say what holds for this run's devices; what paces it, with ``--realtime``."""
    if not realtime and all(part.kind != "device" for part in scenario.components.values()):
        return None
    from cosim.cli.support.devices import device_session, say

    device_session(enable_output=enable_output, yes=yes, dead_man=dead_man)
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
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    rate = float(scenario.base_rate)
    end = scenario.ticks / rate
    bar = Progress(
        TextColumn(scenario.name),
        BarColumn(),
        TextColumn("{task.fields[note]}"),
        console=Console(stderr=True),
        transient=True,
        auto_refresh=False,
    )
    with bar:
        task = bar.add_task("", total=scenario.ticks, note="")

        def show(ticks: int, wall_time: float) -> None:
            factor = ticks / rate / wall_time if wall_time else 0.0
            note = f"{ticks / rate:.1f} of {end:g} s · {factor:.3g} × real time"
            bar.update(task, completed=ticks, note=note, refresh=True)

        yield show
