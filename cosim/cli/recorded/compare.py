"""``cohaptic compare``: in what two runs differ."""

from __future__ import annotations

import json
import sys
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.values import PLOTS, OutputFile

if TYPE_CHECKING:
    from cosim.record.reader import Run
    from cosim.report.comparison import Change, RunComparison, SignalDifference

SHOWN = 12
DRAWN = 4


@click.command("compare", cls=JsonCommand)
@click.argument("one", type=click.Path(path_type=Path), shell_complete=run_folders)
@click.argument("other", type=click.Path(path_type=Path), shell_complete=run_folders)
@click.option(
    "--figure",
    type=OutputFile(PLOTS),
    help="Draw the first signals that differ, both runs over one another.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(one: Path, other: Path, *, figure: Path | None, as_json: bool) -> None:
    """Tell in what the run OTHER differs from the run ONE.

    The scenario, versions, measures, and the first tick and signal that differ, bit for bit. Exit
    status: 0 both have the same signals and values, 1 they have not, 2 one cannot be read.
    """
    from cosim.record import open_run
    from cosim.report.comparison import compare_runs

    with ExitStack() as stack:
        runs = [stack.enter_context(open_run(folder)) for folder in (one, other)]
        found = compare_runs(*runs)
        if figure is not None:
            _draw(runs, found, figure)
        if as_json:
            click.echo(json.dumps({"equal": found.are_equal, **asdict(found)}))
        else:
            click.echo("\n".join(_lines(found, runs)))
    sys.exit(int(not found.are_equal))


def _draw(runs: list[Run], found: RunComparison, figure: Path) -> None:
    names = [each.name for each in found.signals if not each.is_text][:DRAWN]
    if not names:
        click.echo(f"{figure}: nothing is drawn, since no number differs.", err=True)
        return
    from fractions import Fraction

    from cosim.plot.figure import draw
    from cosim.plot.kinds import KINDS
    from cosim.plot.series import Span, select

    draw(KINDS["time"](select(runs, names), Span(Fraction(0), None)), figure)


def _lines(found: RunComparison, runs: list[Run]) -> list[str]:
    lines: list[str] = []
    for title, changes in (
        ("scenario", found.scenario),
        ("versions", found.versions),
        ("measures", found.measures),
        ("recorded", found.recorded),
    ):
        lines += _section(title, changes)
    for run, names in zip(runs, found.only_in, strict=True):
        if names:
            shown = ", ".join(names[:SHOWN])
            more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
            lines.append(f"only {run.folder} has {shown}{more}")
    if found.lengths[0] != found.lengths[1]:
        lines.append(f"{found.lengths[0]} ticks, and {found.lengths[1]}")
    if found.signals:
        first = found.signals[0]
        time = float((runs[0].start_tick + first.tick) / runs[0].base_rate)
        lines.append(
            f"{len(found.signals)} signals differ, first {first.name} at tick {first.tick} "
            f"(t = {time:g} s)"
        )
        width = max(len(each.name) for each in found.signals[:SHOWN])
        lines += [
            f"  {each.name.ljust(width)}  since tick {each.tick}, {each.rows} rows{_by(each)}"
            for each in found.signals[:SHOWN]
        ]
        if len(found.signals) > SHOWN:
            lines.append(f"  and {len(found.signals) - SHOWN} more")
    elif not found.compared:
        lines.append("no value is compared: nothing was recorded alike, at the same times, in both")
    else:
        alike = "of what was recorded alike, " if found.recorded else ""
        length = min(found.lengths)
        lines.append(f"{alike}no value differs in the first {length} ticks, bit for bit")
    return lines


def _by(signal: SignalDifference) -> str:
    if signal.is_text:
        return ""
    if signal.largest is None:
        return ", where one is not a number"
    return f", by up to {signal.largest:.3g} {signal.unit}".rstrip()


def _section(title: str, changes: list[Change]) -> list[str]:
    lines = [f"  {path}: {_show(one)} → {_show(other)}" for path, one, other in changes[:SHOWN]]
    more = [f"  and {len(changes) - SHOWN} more"] if len(changes) > SHOWN else []
    return [title, *lines, *more] if changes else []


def _show(value: Any) -> str:
    if value is None:
        return "nothing"
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return text if len(text) <= 60 else f"{text[:57]}…"
