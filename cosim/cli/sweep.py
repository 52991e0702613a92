"""``cohaptic sweep``: many runs of one scenario, and what differs between them."""

from __future__ import annotations

import sys
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.values import OutputFolder, Quantity

if TYPE_CHECKING:
    from fractions import Fraction

    from cosim.sweep.planning.plan import Request
    from cosim.sweep.sweep import Follow, Step, SweepOutcome


MOST = 1_000_000
_MINUTE = 60.0
_PLAIN = ("seeds", "sample", "points", "sample_seed", "start", "check_every")
"""Options that take the place of what a plan says."""
COUNT, SEED = click.IntRange(1, MOST), click.IntRange(0, 2**31)


@click.command("sweep", cls=JsonCommand)
@click.argument("what", metavar="PLAN|SCENARIO", shell_complete=scenario_names)
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="Lay another file over it.")
@click.option("--set", "sets", multiple=True, metavar="A.B=C", help="Change a value in all runs.")
@click.option(
    "--vary",
    multiple=True,
    metavar="PLACE[,PLACE]=VALUES",
    help="Vary a value: vr_*.mass=0.2,0.4 or lan.loss=0..0.5/6 or lan.round_trip_delay=0..39 or "
    "coupler_1.stiffness='100..8000/40 log'; may be repeated.",
)
@click.option("--seeds", type=COUNT, metavar="N", help="Repeat with the seeds 1 to N.")
@click.option(
    "--sample",
    type=click.Choice(["grid", "latin_hypercube", "sobol"]),
    default=None,
    help="How points are chosen from the ranges.  [default: grid]",
)
@click.option("--points", type=COUNT, help="How many points a sample has.")
@click.option(
    "--sample-seed",
    type=SEED,
    help="What a sample is drawn from.  [default: 0]",
)
@click.option(
    "--boundary", is_flag=True, help="Run a grid of two only where good turns into failed."
)
@click.option("--start", metavar="TIME", help="Run what comes before this time once only.")
@click.option(
    "--expect",
    multiple=True,
    metavar="TARGET:PREDICATE=VALUE",
    help="What a good run is: coupler_11.force:growth_below=0; may be repeated.",
)
@click.option(
    "--measure", multiple=True, metavar="TARGET:NAME", help="Measure more: vr_a.box_pose.y:max_abs."
)
@click.option(
    "--out",
    type=OutputFolder(),
    help="Folder of the sweep; what is known there is not run again.  "
    "[default: sweeps/<scenario>-<n>]",
)
@click.option(
    "--workers", type=click.IntRange(1, 1024), help="Processes. [default: one a processor]"
)
@click.option("--scheduler", metavar="ADDRESS", help="Dask's scheduler, as tcp://host:8786.")
@click.option("--timeout", type=Quantity("s"), help="The longest that one run may take.")
@click.option("--check-every", type=click.IntRange(0, MOST), metavar="N", help="Compare 1 in N.")
@click.option("--figure/--no-figure", default=True, help="Draw sweep.png.")
@click.option("--json", "as_json", is_flag=True, help="Print the result as one JSON object.")
def command(
    *,
    out: Path | None,
    workers: int | None,
    scheduler: str | None,
    timeout: Fraction | None,
    figure: bool,
    as_json: bool,
    **asked: Any,
) -> None:
    """Run SCENARIO many times, or what a PLAN asks for, and tell what differs.

    Options add to a plan or take the place of what it says. Expectations give each run its verdict.
    Exit status: 0 every run ended, whatever its verdict; 1 some run did not; 2 something that was
    given cannot be used.
    """
    from cosim.reading import FORMS
    from cosim.sweep.planning.plan import plan_of
    from cosim.sweep.results.table import best_format, write_table
    from cosim.sweep.sweep import run_sweep

    plan = plan_of(request_of(asked), FORMS)
    pool = None
    if scheduler is not None:
        if workers is not None or timeout is not None:
            raise InputError("--workers and --timeout are for workers on this machine.")
        from cosim.sweep.work.cluster import DaskPool

        pool = DaskPool(plan.job, scheduler)
    with _progress(plan.name) as follow:
        outcome = run_sweep(
            plan,
            out,
            workers=workers,
            pool=pool,
            follow=follow,
            timeout=None if timeout is None else float(timeout),
        )
    table = outcome.folder / f"results{best_format()}"
    write_table(outcome, table)
    picture = outcome.folder / "sweep.png"
    if figure:
        from cosim.sweep.results.figures import draw_sweep

        draw_sweep(outcome, picture)
    _show(outcome, table, as_json=as_json)
    sys.exit(int(any(not result.is_over for result in outcome.results)))


def request_of(asked: Mapping[str, Any]) -> Request:
    """What the command's arguments ask for, by their names: those of a plan, changed by options."""
    request = _request(asked["what"])
    return _changed(
        request,
        overlays=[*request.overlays, *asked["overlays"]],
        sets=[*request.sets, *asked["sets"]],
        vary={**request.vary, **_varied(asked["vary"])},
        boundary=asked["boundary"] or None,
        expect=_expected(request.expect, asked["expect"]),
        measure=_measured(request.measure, asked["measure"]),
        **{name: asked[name] for name in _PLAIN},
    )


def _request(what: str) -> Request:
    from cosim.sweep.planning.plan import Request, is_plan, read_plan

    file = Path(what)
    return read_plan(file) if file.is_file() and is_plan(file) else Request(scenario=what)


def _changed(request: Request, **given: Any) -> Request:
    from dataclasses import replace

    return replace(request, **{key: value for key, value in given.items() if value is not None})


def _varied(texts: tuple[str, ...]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for text in texts:
        places, equals, values = text.partition("=")
        if not equals or not places.strip() or not values.strip():
            raise InputError(f"--vary {text}: write PLACE=VALUES, such as lan.loss=0..0.5/6.")
        several = [place.strip() for place in places.split(",")]
        if several[0] in found:
            raise InputError(
                f"--vary {text}: {several[0]} is varied already; write all values in one."
            )
        found[several[0]] = {"set": several, "values": values}
    return found


def _expected(known: Any, texts: tuple[str, ...]) -> dict[str, Any]:
    from cosim.base.document.yaml_reader import parse_yaml

    found: dict[str, Any] = dict(known)
    given: set[tuple[str, str]] = set()
    for text in texts:
        left, equals, value = text.partition("=")
        target, colon, name = left.rpartition(":")
        if not colon or not equals:
            raise InputError(f"--expect {text}: write TARGET:PREDICATE=VALUE.")
        plain = parse_yaml(value, f"--expect {text}", has_lines=False).plain()
        if (target, name) in given:
            raise InputError(f"--expect {text}: {name.strip()} is given twice.")
        given.add((target, name))
        found[target.strip()] = {**found.get(target.strip(), {}), name.strip(): plain}
    return found


def _measured(known: Any, texts: tuple[str, ...]) -> dict[str, Any]:
    found: dict[str, Any] = {
        target: [names] if isinstance(names, str) else list(names)
        for target, names in known.items()
    }
    for text in texts:
        target, colon, name = text.rpartition(":")
        if not colon:
            raise InputError(f"--measure {text}: write TARGET:NAME, as in vr_a.box_pose.y:max_abs.")
        found.setdefault(target.strip(), []).append(name.strip())
    return found


@contextmanager
def _progress(name: str) -> Generator[Follow | None]:
    """On stderr the runs, the failures and the time left: a bar, or now and then a line."""
    if not sys.stderr.isatty():
        yield lines_of(name)
        return
    from cosim.cli.support.terminal.bar import progress_bar

    with progress_bar(name) as bar:
        task = bar.add_task("", total=None, note="")
        shown = 0.0

        def show(step: Step) -> None:
            nonlocal shown
            if step.seconds - shown < 0.1 and step.done < step.total:
                return
            shown = step.seconds
            bar.update(task, total=step.total, completed=step.done, note=_note(step), refresh=True)

        yield show


def lines_of(name: str) -> Follow:
    """What says in a log, where there is no terminal, how far a sweep is: once a minute."""
    shown = 0.0

    def show(step: Step) -> None:
        nonlocal shown
        if step.seconds - shown >= _MINUTE:
            shown = step.seconds
            click.echo(f"{name}: {_note(step)}", err=True)

    return show


def _note(step: Step) -> str:
    left = "" if step.left is None else f" · {_span(step.left)} left"
    return f"{step.done} of {step.total} · {step.failed} not good{left}"


def _span(seconds: float) -> str:
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


def _show(outcome: SweepOutcome, table: Path, *, as_json: bool) -> None:
    from collections import Counter

    from cosim.sweep.results.table import failures_text

    counts = Counter(result.status for result in outcome.results)
    disagreements = outcome.disagreements
    if as_json:
        import json

        content = {
            "folder": str(outcome.folder),
            "table": str(table),
            "runs": len(outcome.results),
            "reused": outcome.reused,
            "statuses": dict(counts),
            "checked": sum(result.checked for result in outcome.results),
            "theory_disagrees": disagreements,
            "failures": [result.as_dict() for result in outcome.failures],
        }
        click.echo(json.dumps(content))
        return
    parts = [f"{count} {status}" for status, count in sorted(counts.items(), reverse=True)]
    reused = f", {outcome.reused} of them known before" if outcome.reused else ""
    click.echo(f"{len(outcome.results)} runs{reused}: {', '.join(parts)}")
    if disagreements is not None:
        click.echo(f"  the theory says otherwise in {disagreements}")
    names = [axis.name for axis in outcome.plan.axes]
    for line in failures_text(outcome.failures, names):
        click.echo(line)
    click.echo(f"  {table}")
