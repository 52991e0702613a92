"""``cohaptic record``: look into a run folder."""

from __future__ import annotations

import json
import math
import re
import sys
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.terminal.width import shown_width
from cosim.cli.support.values import OutputFolder, Quantity

if TYPE_CHECKING:
    from cosim.record.reader import Run

RUN = click.argument("run", type=click.Path(path_type=Path), shell_complete=run_folders)
JSON = click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")


@click.group("record")
def command() -> None:
    """Look into run folders: what is in them, whether two are equal, other formats."""


@command.command("digest", cls=JsonCommand)
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "--expect", metavar="DIGEST|RUN", help="What each has to have, or the run that has it; else 1."
)
@JSON
def digest_command(runs: tuple[Path, ...], *, expect: str | None, as_json: bool) -> None:
    """Print a hash over ticks, names, units and values: equal runs have equal digests."""
    from cosim.record import digest, open_run

    found: dict[str, str] = {}
    for folder in runs:
        with open_run(folder) as run:
            found[str(folder)] = digest(run)
    wanted = None if expect is None else _expected(expect)
    others = [name for name, value in found.items() if wanted not in {None, value}]
    if as_json:
        equal = len({*found.values(), *([wanted] if wanted else [])}) == 1
        click.echo(json.dumps({"digests": found, "equal": equal}))
    else:
        for name, value in found.items():
            click.echo(f"{value}  {name}")
    for name in others:
        click.echo(f"{name} is not {expect}", err=as_json)
    if others:
        sys.exit(1)


def _expected(text: str) -> str:
    """A digest that was given, or that of a run."""
    from cosim.record import digest, open_run

    if Path(text).exists():
        with open_run(text) as run:
            return digest(run)
    if re.fullmatch(r"[0-9a-fA-F]{64}", text) is None:
        raise InputError(f"--expect {text}: it is neither a run nor a digest of 64 digits.")
    return text.lower()


@command.command("summary", cls=JsonCommand)
@RUN
@JSON
def summary_command(run: Path, *, as_json: bool) -> None:
    """Print the summary of a run; that of one that was killed is computed from its record."""
    from cosim.record import open_run
    from cosim.report.summary import read_summary, summarise

    summary = read_summary(run)
    if summary is None:
        with open_run(run) as opened:
            summary = summarise(opened)
    click.echo(json.dumps(summary.content) if as_json else summary.text(shown_width()))
    if summary.content["message"]:
        click.echo(summary.content["message"], err=True)


@command.command("list", cls=JsonCommand)
@RUN
@JSON
def list_command(run: Path, *, as_json: bool) -> None:
    """List the recorded signals with their rates, units and descriptions."""
    from cosim.record import open_run

    with open_run(run) as opened:
        if as_json:
            content = {
                "base_rate": str(opened.base_rate),
                "ticks": opened.ticks,
                "groups": {
                    group.name: {
                        "rate": str(group.rate),
                        "period": group.period,
                        "rows": group.rows,
                        "signals": {
                            signal.name: {
                                "unit": signal.unit,
                                "type": "float64" if signal.is_float else "int64",
                                "description": signal.description,
                            }
                            for signal in group.signals.values()
                        },
                        "texts": {
                            text.name: {
                                "type": "Binary" if text.column.is_binary else "String",
                                "changes": len(text.changes),
                                "description": text.column.description,
                            }
                            for text in group.texts.values()
                        },
                    }
                    for group in opened.groups.values()
                },
            }
            click.echo(json.dumps(content))
            return
        for group in opened.groups.values():
            click.echo(f"{group.name}: {group.rate} Hz, {group.rows} rows")
            width = max((len(name) for name in [*group.signals, *group.texts]), default=0)
            for signal in group.signals.values():
                line = f"  {signal.name.ljust(width)}  {signal.unit:8}  {signal.description}"
                click.echo(line.rstrip())
            for text in group.texts.values():
                kind = "binary" if text.column.is_binary else "text"
                line = f"  {text.name.ljust(width)}  {kind:8}  {text.column.description}"
                click.echo(line.rstrip())


@command.command("export", cls=JsonCommand)
@RUN
@click.option(
    "--format", "kind", default="csv", help="csv, mat, mcap, mf4 or parquet. [default: csv]"
)
@click.option("--out", type=OutputFolder(), help="Folder. [default: export in the run's folder]")
@click.option("--held", is_flag=True, help="One table at the fastest rate, slower signals held.")
@click.option(
    "--signal",
    "signals",
    multiple=True,
    help="These signals: a name, or a pattern with * and ?.  [default: all]",
)
@click.option("--from", "start", type=Quantity("s"), help="Begin here.  [default: the beginning]")
@click.option("--until", type=Quantity("s"), help="End here.  [default: the run's end]")
@JSON
def export_command(
    run: Path,
    kind: str,
    out: Path | None,
    *,
    held: bool,
    signals: tuple[str, ...],
    start: Fraction | None,
    until: Fraction | None,
    as_json: bool,
) -> None:
    """Write a run as csv, mat, mcap, mf4 or parquet; held signals stay held."""
    from cosim.record import open_run
    from cosim.record.export.formats import export

    with open_run(run) as opened:
        span = _span(opened, start, until)
        folder = out or opened.folder / "export"
        paths = export(opened, kind, folder, held=held, patterns=signals, span=span)
    if as_json:
        click.echo(json.dumps({"files": [str(path) for path in paths]}))
    else:
        for path in paths:
            click.echo(str(path))


def _span(run: Run, start: Fraction | None, until: Fraction | None) -> tuple[int, int | None]:
    """Base ticks from one time to the other; the tick at the end is in it."""
    if start is not None and until is not None and until < start:
        raise InputError(f"--until {float(until):g} s is before --from {float(start):g} s.")
    begin = 0 if start is None else math.ceil(start * run.base_rate) - run.start_tick
    end = None if until is None else math.floor(until * run.base_rate) - run.start_tick + 1
    return begin, end


@command.command("compress", cls=JsonCommand)
@click.argument(
    "runs",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path),
    shell_complete=run_folders,
)
@JSON
def compress_command(runs: tuple[Path, ...], *, as_json: bool) -> None:
    """Make the records of runs smaller without loss; digests stay what they are."""
    from cosim.record.rewriting.compression import compress

    done = {str(folder): compress(folder) for folder in runs}
    if as_json:
        sizes = {
            name: None if found is None else {"before": found.before, "after": found.after}
            for name, found in done.items()
        }
        click.echo(json.dumps({"runs": sizes}))
        return
    for name, found in done.items():
        if found is None:
            click.echo(f"{name}: it is compressed already")
        else:
            before, after = found.before / 1e6, found.after / 1e6
            click.echo(f"{name}: {before:.1f} MB before, {after:.1f} MB now")


@command.command("compact", cls=JsonCommand)
@RUN
def compact_command(run: Path) -> None:
    """Cut the datasets of a run that was killed to the rows that it reached."""
    from cosim.record.reader import RUN_FILE, open_run
    from cosim.record.rewriting.compact import compact

    with open_run(run) as opened:
        path = opened.folder / RUN_FILE
    done = compact(path)
    click.echo(f"{path}: {'cut to what was reached' if done else 'nothing was cut'}")
