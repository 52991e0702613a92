"""``cohaptic theory figure``: the figures of chapters 5 and 6."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import FIGURES, OutputFile
from cosim.theory.chapters import chapter_5, chapter_6
from cosim.theory.models.timing import Timing
from cosim.theory.stability.map import stability_maps


@click.command(cls=JsonCommand)
@click.argument("number", metavar="NUMBER")
@click.option(
    "--out",
    type=OutputFile(FIGURES),
    required=True,
    help="The file: .png, .svg or .pdf.",
)
@click.option("--points", type=click.IntRange(2, 2001), default=201, show_default=True)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(number: str, out: Path, points: int, as_json: bool) -> None:
    """Draw one of the figures 5.1 to 5.4, 6.2, 6.4 and 6.5 of the thesis."""
    result = {"figure": number, "out": str(out), **draw(number, out, points)}
    click.echo(json.dumps(result) if as_json else f"Figure {number} written to {out}")


def draw(number: str, out: Path, points: int) -> dict[str, Any]:
    """Draw a figure into a file, and say what is in it.

    Raises:
        InputError: where the thesis has no such figure here.
    """
    if number in chapter_5.FIGURES:
        from cosim.report.theory_figures import draw_map

        shown = chapter_5.FIGURES[number]
        x, y = shown.axes(points)
        cells = stability_maps(shown.parameters(), Timing(), x, y, chapter_5.DELAYS)
        fixed = ", ".join(f"{name} = {value:g} N/m" for name, value in shown.fixed.items())
        title = f"Figure {number}: stability of the {shown.architecture} loop"
        draw_map(cells, (x, y), chapter_5.DELAYS, f"{title}\n{fixed}" if fixed else title, out)
        return {
            "stable_share": {
                f"n={delay}": float(cells[place].mean())
                for place, delay in enumerate(chapter_5.DELAYS)
            }
        }
    if number in chapter_6.FIGURES:
        from cosim.report.theory_figures import draw_admittance

        figure = chapter_6.FIGURES[number]
        unit = "m/(N·s)" if figure.case == "free" else "m/N"
        responses = figure.responses(chapter_6.frequencies(points))
        title = f"Figure {number}: {figure.title}, n = 1"
        draw_admittance({str(felt): r for felt, r in responses.items()}, unit, title, out)
        return {"curves": list(figure.curves)}
    known = [*chapter_5.FIGURES, *chapter_6.FIGURES]
    raise InputError(f"There is no figure {number!r}.{did_you_mean(number, known)}")
