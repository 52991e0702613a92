"""``cohaptic theory page``: the page that compares the thesis with this library."""

from __future__ import annotations

from pathlib import Path

import click

from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import OutputFile


@click.command(cls=JsonCommand)
@click.option(
    "--out",
    type=OutputFile(),
    help="Write it here, with its figures.",
)
def command(out: Path | None) -> None:
    """Print docs/thesis.md: chapters 3 to 6, printed and computed.

    With --out the figures go to images/theory beside the page.
    """
    from cosim.theory.chapters.page.whole import thesis_page

    page = thesis_page()
    if out is None:
        click.echo(page, nl=False)
        return
    from cosim.cli.theory.figure import draw
    from cosim.theory.chapters import chapter_5, chapter_6

    folder = out.parent / "images" / "theory"
    with writing(out):
        folder.mkdir(parents=True, exist_ok=True)
        for number in (*chapter_5.FIGURES, *chapter_6.FIGURES):
            draw(number, folder / f"figure_{number.replace('.', '_')}.png", 201)
        out.write_text(page, encoding="utf-8")
    click.echo(f"{out} written, figures in {folder}")
