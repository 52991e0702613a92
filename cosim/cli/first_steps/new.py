"""``cohaptic new``: a starter scenario of one's own, by questions."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number, OutputFile

MOST_SAMPLES = 1000


@click.command("new", cls=JsonCommand)
@click.argument("file", type=OutputFile((".yaml", ".yml")))
@click.option(
    "--motion", type=click.Choice(("plane", "axis")), help="A box in the plane, or one axis."
)
@click.option("--users", type=click.IntRange(1, 4), help="How many people share the object.")
@click.option(
    "--architecture",
    type=click.Choice(("distributed", "centralized")),
    help="A copy of the object at each user, or one.",
)
@click.option(
    "--delay", type=click.IntRange(0, MOST_SAMPLES), help="Round trip, in samples of the network."
)
@click.option("--loss", type=Number(0, 1), help="Share of the packets that is lost.")
@click.option("--mass", type=Number(1e-3, 1e3), help="Of the object (kg).")
@click.option("--duration", metavar="TIME", help="How long it runs (s).")
def command(
    *,
    file: Path,
    motion: str | None,
    users: int | None,
    architecture: str | None,
    delay: int | None,
    loss: float | None,
    mass: float | None,
    duration: str | None,
) -> None:
    """Write FILE, a short scenario that stands on a bundled one.

    What no option says is asked at a terminal; elsewhere it is as in the bundled one.
    """
    from cosim.base.system.writing import writing
    from cosim.cli.first_steps.starter import Answers, ground, starter

    if file.exists():
        raise InputError(f"{file} is there already; a scenario is never written over another.")
    asks = sys.stdin.isatty()
    given = {"motion": motion, "users": str(users) if users else None, "architecture": architecture}
    below = ground(given, _choose if asks else _first).name
    answers = Answers(delay, loss, mass, duration)
    text = starter(below, answers, file.stem, _ask if asks else None)
    with writing(file):
        file.write_text(text, encoding="utf-8")
    click.echo(f"{file} is written. 'cohaptic check {file}' says what is in it;")
    click.echo(f"'cohaptic run {file}' runs it.")


def _first(trait: str, values: list[str]) -> str:
    del trait
    return values[0]


def _choose(trait: str, values: list[str]) -> str:
    kind = click.Choice(values)
    return str(click.prompt(trait.capitalize(), type=kind, default=values[0], err=True))


def _ask(question: str, default: str, judge: Callable[[str], None]) -> str:
    def judged(answer: str) -> str:
        try:
            judge(answer)
        except InputError as error:
            raise click.UsageError(error.message) from error  # it is asked again
        return answer

    return str(click.prompt(question, default=default, value_proc=judged, err=True))
