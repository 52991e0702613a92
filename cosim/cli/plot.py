"""``cohaptic plot``: signals of one or several runs as a figure for a screen or a paper."""

from __future__ import annotations

import json
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.effect import refuse_without
from cosim.cli.support.terminal.complete import runs_and_signals
from cosim.cli.support.values import PLOTS, OutputFile, Quantity
from cosim.plot.style import PAGE_FORMAT

if TYPE_CHECKING:
    from cosim.record.reader import Run

KINDS = ("time", "difference", "spectrum", "phase", "histogram")


@click.command("plot", cls=JsonCommand)
@click.argument(
    "what",
    nargs=-1,
    required=True,
    metavar="RUN... SIGNAL...",
    shell_complete=runs_and_signals,
)
@click.option(
    "--kind",
    type=click.Choice(KINDS),
    default="time",
    show_default=True,
    help="Over time; first run or signal less the others; density; second over first; shares.",
)
@click.option(
    "--from", "start", type=Quantity("s"), default="0", help="Begin here.  [default: 0 s]"
)
@click.option("--until", type=Quantity("s"), help="End here.  [default: the run's end]")
@click.option(
    "--width",
    type=click.Choice(("one", "two")),
    default="two",
    show_default=True,
    help="As wide as one or as two columns of a journal (88 and 180 mm).",
)
@click.option("--title", default="", help="A line above the figure.")
@click.option(
    "--out",
    type=OutputFile(PLOTS),
    help="The figure; an .html is one page that is zoomed.  [default: plot.png in the run]",
)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(
    *,
    what: tuple[str, ...],
    kind: str,
    start: Fraction,
    until: Fraction | None,
    width: str,
    title: str,
    out: Path | None,
    as_json: bool,
) -> None:
    """Draw SIGNALs (names, or patterns with * and ?) of RUN folders; each value is held.

    One panel for each unit; several runs lie over one another. Without a SIGNAL the overview of
    one run is drawn again.
    """
    from cosim.plot.figure import draw
    from cosim.plot.kinds import KINDS as DRAWN
    from cosim.plot.series import Span, select

    if until is not None and until <= start:
        raise InputError(f"--until {float(until):g} s is not after --from {float(start):g} s.")
    with ExitStack() as stack:
        runs, patterns = _sorted(what, stack)
        series = select(runs, patterns)
        if out is not None and out.suffix.lower() == PAGE_FORMAT:
            _refuse_width(width)
        if patterns:
            target = out or runs[0].folder / "plot.png"
            draw(DRAWN[kind](series, Span(start, until)), target, width=width, title=title)
        else:
            refuse_without(
                "SIGNAL",
                {
                    "--kind": kind != "time",
                    "--from": start > 0,
                    "--until": until,
                    "--width": width != "two",
                    "--title": bool(title),
                },
                "the overview is drawn as it is",
            )
            target = out or runs[0].folder / "overview.png"
            _draw_overview(runs[0], target)
    if as_json:
        click.echo(json.dumps({"figure": str(target), "signals": [t.label for t in series]}))
    else:
        click.echo(str(target))


def _refuse_width(width: str) -> None:
    """A page is as wide as its window."""
    if width != "two":
        raise InputError(
            f"--width {width}: a page is as wide as its window; leave it out, or name a .pdf."
        )


def _sorted(what: tuple[str, ...], stack: ExitStack) -> tuple[list[Run], list[str]]:
    """Run folders first, then what is to be drawn of them.

    Raises:
        InputError: there is no run or no signal among them, or one of the runs cannot be read.
    """
    from cosim.record.reader import RUN_FILE, open_run

    places = [text for text in what if Path(text).exists() or "/" in text]
    patterns = [text for text in what if text not in places]
    if not places:
        raise InputError(f"{what[0]}: there is no run folder of that name (one with a {RUN_FILE}).")
    runs = [stack.enter_context(open_run(place)) for place in dict.fromkeys(places)]
    if not patterns and len(runs) > 1:
        some = ", ".join(list(runs[0].signals)[:4])
        raise InputError(
            f"name the signals to draw, such as {some}; `cohaptic record list {places[0]}` lists "
            "what was recorded."
        )
    return runs, patterns


def _draw_overview(run: Run, target: Path) -> None:
    """The overview of a run, as it is drawn after it."""
    from cosim.report.overview import draw_overview
    from cosim.report.summary import facts, read_summary, summarise

    if target.suffix.lower() != ".png":
        raise InputError(f"{target}: the overview is a .png; name signals for another format.")
    summaries = {name: signal.summary() for name, signal in run.signals.items()}
    summary = read_summary(run.folder) or summarise(run, (), summaries)
    with writing(target):
        draw_overview(run, target, summaries, facts(summary.content))
