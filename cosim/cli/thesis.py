"""``cohaptic thesis``: rerun the thesis's experiments and hold its statements against them."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import OutputFile, OutputFolder


@click.command("thesis", cls=JsonCommand)
@click.option(
    "--out",
    type=OutputFolder(),
    help="Folder for the page and the runs; new or empty. [default: runs/thesis-<n>]",
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Runs at a time. [default: processors]"
)
@click.option(
    "--page",
    type=OutputFile((".md",)),
    help="Also write docs/experiments.md here, and its numbers beside it as .json.",
)
@click.option("--json", "as_json", is_flag=True, help="Print the verdicts as one JSON object.")
def command(out: Path | None, workers: int | None, page: Path | None, *, as_json: bool) -> None:
    """Rerun the experiments of chapters 7 and 8, and what lies past them, onto one page.

    Exit status: 0 where every statement was decided, 1 where a run failed or one could not be.
    """
    from cosim.record.folder import new_folder
    from cosim.thesis.claims.chapter_8 import STATEMENTS
    from cosim.thesis.claims.past import EXTENSIONS
    from cosim.thesis.claims.statement import runs_of
    from cosim.thesis.experiments import Ran, run_all
    from cosim.thesis.pages.beyond_figures import draw_beyond
    from cosim.thesis.pages.docs import experiments_page
    from cosim.thesis.pages.figures import draw_figures
    from cosim.thesis.pages.findings import BeyondPart
    from cosim.thesis.pages.html import write_page
    from cosim.thesis.results import Results
    from cosim.thesis.sweeps.beyond import sweep

    folder = new_folder("thesis", out)

    def told(ran: Ran) -> None:
        click.echo(f"  {ran.name}{': ' + ran.failure if ran.failure else ''}", err=True)

    wanted = runs_of((*STATEMENTS, *EXTENSIONS))
    runs = run_all(wanted, folder, workers=workers, told=told)
    click.echo("  sweeps", err=True)
    results = Results.of(wanted, runs, sweep(workers))
    (folder / "results.json").write_text(results.text(), encoding="utf-8")
    decided, extended = results.decided(STATEMENTS), results.decided(EXTENSIONS)
    figures = {name: folder / file for name, file in draw_figures(runs, folder).items()}
    html = folder / "thesis.html"
    beyond = BeyondPart(extended, results.sweeps, draw_beyond(results.sweeps, folder))
    write_page(html, decided, wanted=wanted, runs=runs, figures=figures, beyond=beyond)
    if page is not None:
        with writing(page):
            page.with_suffix(".json").write_text(results.text(), encoding="utf-8")
            page.write_text(experiments_page(results), encoding="utf-8")
    decided = [*decided, *extended]
    if as_json:
        import json

        verdicts = {item.statement.name: item.verdict for item in decided}
        click.echo(json.dumps({"page": str(html), "verdicts": verdicts}))
    else:
        for item in decided:
            click.echo(f"{item.verdict:18}{item.statement.section:10}{item.statement.claim}")
        click.echo(f"\n{html}")
    undecided = any(
        item.verdict == "cannot be decided" and not item.statement.undecidable for item in decided
    )
    sys.exit(1 if undecided else 0)
