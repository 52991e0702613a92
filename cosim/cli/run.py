"""``cohaptic run``: a scenario, its record, its summary and its figure."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.devices import output_options
from cosim.cli.support.drawings import drawing_options
from cosim.cli.support.pace import miss_options, refuse_without_realtime
from cosim.cli.support.page import page_options
from cosim.cli.support.run.one import RunOptions
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.terminal.journal import Journal, journal_options
from cosim.cli.support.terminal.width import shown_width
from cosim.cli.support.values import OutputFile, OutputFolder

if TYPE_CHECKING:
    from cosim.cli.support.pace import Policy
    from cosim.cli.support.run.junit import RunEnd


@click.command("run", cls=JsonCommand)
@click.argument("scenarios", nargs=-1, metavar="[SCENARIO]...", shell_complete=scenario_names)
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
    "--stop-time",
    metavar="TIME",
    help="Of an FMU or a system, not a scenario: when to stop.",
)
@click.option("--step-size", metavar="TIME", help="Of an FMU: how long its steps are.")
@click.option(
    "--out",
    type=OutputFolder(),
    help="Folder for the run, new or empty; of several runs the folder for theirs. "
    "[default: runs/<scenario>-<n>]",
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
@click.option(
    "--junit", type=OutputFile(), help="Write how it ended, and every verdict, as JUnit's XML."
)
@journal_options
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def command(
    *,
    scenarios: tuple[str, ...],
    overlays: tuple[str, ...],
    sets: tuple[str, ...],
    duration: str | None,
    out: Path | None,
    stop_time: str | None,
    step_size: str | None,
    snapshots: tuple[str, ...],
    origin: str | None,
    figure: bool,
    report: bool | None,
    realtime: bool,
    live: bool,
    foxglove: bool,
    live_at: str | None,
    on_miss: Policy | None,
    cpu: int | None,
    enable_output: bool,
    yes: bool,
    dead_man: str | None,
    junit: Path | None,
    log_file: Path | None,
    verbose: bool,
    as_json: bool,
) -> None:
    """Run SCENARIO, a file or the name of a bundled one, and record it; several one by one.

    An FMU, or the folder of an unpacked one, runs alone: --stop-time and --step-size as its default
    experiment says unless they are given, and --set VARIABLE=VALUE for its parameters.

    Exit status: 0 good; 1 the run failed, was interrupted, or an expectation was not met;
    2 something that was given cannot be used; of several the highest.

    With --from, the scenario is the one that the earlier run resolved, and only --duration may
    differ. The new record is whole; it fails where both runs should have the same values and have
    not.
    """
    from cosim.cli.support.run.several import answer, run_each

    refuse_without_realtime(realtime=realtime, on_miss=on_miss, cpu=cpu)
    options = RunOptions(
        overlays=overlays,
        sets=sets,
        duration=duration,
        stop_time=stop_time,
        step_size=step_size,
        snapshots=snapshots,
        origin=origin,
        figure=figure,
        report=report,
        realtime=realtime,
        live=live,
        foxglove=foxglove,
        live_at=live_at,
        on_miss=on_miss,
        cpu=cpu,
        enable_output=enable_output,
        yes=yes,
        dead_man=dead_man,
    )
    journal = Journal(log_file, verbose=verbose)
    ends: list[RunEnd] = []
    is_alone = len(scenarios) < 2
    for end in run_each(scenarios or (None,), out, options, journal):
        ends.append(end)
        _tell(end, journal, as_text=not as_json, is_alone=is_alone)
    if junit is not None:
        _write_junit(junit, ends)
    if is_alone and ends[0].error is not None:
        raise ends[0].error
    if as_json:
        click.echo(json.dumps(answer(ends, is_alone=is_alone)))
    sys.exit(max(end.status for end in ends))


def _tell(end: RunEnd, journal: Journal, *, as_text: bool, is_alone: bool) -> None:
    """Show how a run ended; the error of the only one is shown by whoever ends the command."""
    from cosim.report.summary import Summary

    if end.content is not None and as_text:
        journal.result(Summary(end.content).text(shown_width()))
    if is_alone and end.error is not None:
        journal.keep(end.message)
    elif end.message:
        journal.say(end.message)


def _write_junit(file: Path, ends: list[RunEnd]) -> None:
    from cosim.base.system.writing import writing
    from cosim.cli.support.run.junit import junit

    with writing(file):
        file.write_bytes(junit(ends))
