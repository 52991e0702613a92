"""``cohaptic scenarios``: what is bundled, a sentence and a picture each."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.terminal.width import shown_width
from cosim.cli.support.values import OutputFolder

WIDTH = 98
"""Columns where there is no terminal."""


@click.command("scenarios", cls=JsonCommand)
@click.argument("names", nargs=-1, metavar="[NAME]...", shell_complete=scenario_names)
@click.option(
    "--pictures",
    type=OutputFolder(),
    help="Run each for its whole length and draw it here, halfway, as NAME.webp.",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(*, names: tuple[str, ...], pictures: Path | None, as_json: bool) -> None:
    """List the bundled scenarios, or say more of those that are NAMEd."""
    from cosim.scenario.source.bundled import bundled_scenarios

    known = {each.name: each for each in bundled_scenarios()}
    for name in names:
        if name not in known:
            from cosim.base.suggest import did_you_mean

            raise InputError(f"there is no bundled scenario '{name}'{did_you_mean(name, known)}")
    chosen = [known[name] for name in names] or list(known.values())
    drawn = {} if pictures is None else {each.name: _draw(each.name, pictures) for each in chosen}
    if as_json:
        entries: list[dict[str, Any]] = [
            {
                "name": each.name,
                "title": each.title,
                "description": each.description,
                "file": str(each.file),
                "picture": str(drawn[each.name]) if drawn.get(each.name) else None,
            }
            for each in chosen
        ]
        click.echo(json.dumps({"scenarios": entries}, indent=2))
        return
    from cosim.report.quantities import fitted

    width = shown_width()
    width = WIDTH if width is None else width
    for each in chosen:
        lines = [each.name, f"  {each.title}"]
        if names:
            lines += [f"  {each.description}", f"  {each.file}"]
        if drawn.get(each.name):
            lines.append(f"  {drawn[each.name]}")
        click.echo(fitted("\n".join(lines), width))


def _draw(name: str, folder: Path) -> Path | None:
    """The picture of a scenario; ``None`` where nothing of it can be drawn."""
    from tempfile import TemporaryDirectory

    from cosim.base.system.writing import writing
    from cosim.reading import load
    from cosim.render.still import draw_still
    from cosim.run import run_scenario

    file = folder / f"{name}.webp"
    with TemporaryDirectory() as scratch, writing(file):
        run = Path(scratch) / "run"
        everything = load(name, sets=["record=['*']"])  # some record a part, without what moves
        run_scenario(everything, run, figure=False)
        file.parent.mkdir(parents=True, exist_ok=True)
        return file if draw_still(run, file) else None
