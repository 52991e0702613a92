"""``cohaptic merge``: the records of several stations as one run."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.width import shown_width
from cosim.cli.support.values import OutputFolder


@click.command("merge", cls=JsonCommand)
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("--out", type=OutputFolder(), help="Folder for the result; new or empty.")
@click.option("--report/--no-report", default=True, help="Make report.html.  [default: report]")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(runs: tuple[Path, ...], out: Path | None, *, report: bool, as_json: bool) -> None:
    """Align the RUNS of the stations of one session on the session's ticks.

    The page of the result has both copies in one scene, how far they are apart, and the numbers of
    both stations beside each other.
    """
    from cosim.cli.support.run.merged_page import write_merged_page
    from cosim.record import open_run
    from cosim.report.summary import summarise
    from cosim.station.merge import merge_runs

    merged = merge_runs(runs, out)
    with open_run(merged.folder) as run:
        page = write_merged_page(run, runs) if report else None
        if as_json:
            click.echo(json.dumps(asdict(merged), default=str))
            return
        click.echo(summarise(run).text(shown_width()))
    if page is not None:
        click.echo(f"both stations: {page}")
    click.echo(f"{merged.signals} signals, session ticks from {merged.first_tick} on")
    if merged.measured is not None:
        scenario = merged.folder / "scenario.resolved.yaml"
        click.echo(f"with these delays simulated: cohaptic run {scenario} --with {merged.measured}")
