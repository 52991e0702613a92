"""``cohaptic thesis``: rerun the thesis's experiments and hold its statements against them."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import OutputFolder


@click.command("thesis", cls=JsonCommand)
@click.option(
    "--out",
    type=OutputFolder(),
    help="Folder for the page and the runs; new or empty. [default: runs/thesis-<n>]",
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Runs at a time. [default: processors]"
)
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts as one JSON object.")
def command(out: Path | None, workers: int | None, *, as_json: bool) -> None:
    """Rerun the experiments of chapters 7 and 8, and what lies past them, onto one page.

    Exit status: 0 where every statement was decided, 1 where a run failed or one could not be.
    """
    from cosim.record.folder import new_folder
    from cosim.record.manifest import write_json
    from cosim.thesis.beyond import sweep
    from cosim.thesis.beyond_figures import draw_beyond
    from cosim.thesis.experiments import Ran, run_all
    from cosim.thesis.extensions import EXTENSION_EXPERIMENTS, EXTENSIONS
    from cosim.thesis.figures import draw_figures
    from cosim.thesis.findings import BeyondPart
    from cosim.thesis.page import write_page
    from cosim.thesis.statements import EXPERIMENTS, STATEMENTS, ablation_runs, decide

    folder = new_folder("thesis", out)

    def told(ran: Ran) -> None:
        click.echo(f"  {ran.name}{': ' + ran.failure if ran.failure else ''}", err=True)

    names = dict.fromkeys((*EXPERIMENTS, *EXTENSION_EXPERIMENTS))
    wanted = {name: (f"thesis/{name}", ()) for name in names}
    wanted |= ablation_runs((*STATEMENTS, *EXTENSIONS))
    runs = run_all(wanted, folder, workers=workers, told=told)
    summaries = {name: ran.summary for name, ran in runs.items()}
    failures = {name: ran.failure for name, ran in runs.items() if ran.failure}
    decided = [*decide(summaries, failures)]
    extended = [*decide(summaries, failures, EXTENSIONS)]
    click.echo("  sweeps", err=True)
    found = sweep(workers)
    write_json(folder / "sweeps.json", found.as_json())
    figures = {name: folder / file for name, file in draw_figures(runs, folder).items()}
    page = folder / "thesis.html"
    beyond = BeyondPart(extended, found, draw_beyond(found, folder))
    write_page(page, decided, runs, figures, beyond)
    decided += extended
    if as_json:
        import json

        verdicts = {item.statement.name: item.verdict for item in decided}
        click.echo(json.dumps({"page": str(page), "verdicts": verdicts}))
    else:
        for item in decided:
            click.echo(f"{item.verdict:18}{item.statement.section:10}{item.statement.claim}")
        click.echo(f"\n{page}")
    undecided = any(
        item.verdict == "cannot be decided" and not item.statement.undecidable for item in decided
    )
    sys.exit(1 if undecided else 0)
