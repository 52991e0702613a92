"""``cohaptic study``: participants through a plan, trial by trial, and the table at the end."""

from __future__ import annotations

import json
from collections.abc import Mapping
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.devices import output_options
from cosim.cli.support.values import OutputFile, OutputFolder

if TYPE_CHECKING:
    from cosim.study.folder import StudyFolder
    from cosim.study.plan import StudyPlan
    from cosim.study.session import StudyTrial

PLAN = click.argument("plan", type=click.Path(path_type=Path))
OUT = click.option("--out", type=OutputFolder(), help="The study's folder. [default: studies/PLAN]")


class StudyGroup(click.Group):
    """``cohaptic study PLAN …`` is ``cohaptic study run PLAN …``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put ``run`` before a plan."""
        named = next((each for each in args if not each.startswith("-")), None)
        if named is not None and named not in self.commands:
            args = ["run", *args]
        return super().parse_args(ctx, args)


@click.group("study", cls=StudyGroup)
def command() -> None:
    """Studies with people: trials in a counterbalanced order, questions, a tidy table.

    cohaptic study PLAN.yaml --participant P01 begins, or goes on where it was left.
    """


@command.command("run", cls=JsonCommand)
@PLAN
@click.option("--participant", required=True, metavar="CODE", help="Who sits there: P01.")
@OUT
@click.option("--realtime/--no-realtime", default=True, help="Keep pace with the clock.")
@click.option("--web", is_flag=True, help="Show the trials and ask on a page, in a browser.")
@click.option(
    "--live-at",
    metavar="HOST:PORT",
    help="Where the page is served. [default: 127.0.0.1, a free port]",
)
@click.option("--hands", is_flag=True, help="The page's pointers move the users' hands.")
@click.option("--emulate", is_flag=True, help="The plan's 'emulated' answers; nothing is paced.")
@output_options
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def run_command(
    *,
    plan: Path,
    participant: str,
    out: Path | None,
    realtime: bool,
    web: bool,
    live_at: str | None,
    hands: bool,
    emulate: bool,
    cpu: int | None,
    enable_output: bool,
    yes: bool,
    dead_man: str | None,
    as_json: bool,
) -> None:
    """Take a participant through PLAN, or go on where that was left."""
    from cosim.cli.support.devices import say
    from cosim.cli.support.effect import given_of
    from cosim.cli.support.run.one import RunOptions
    from cosim.cli.support.study.hands import ParticipantHands
    from cosim.cli.support.study.participants import seated
    from cosim.cli.support.study.trials import TrialRunner
    from cosim.study.session import take_part

    study, folder = _opened(plan, out)
    devices = {
        "--cpu": cpu,
        "--enable-output": enable_output,
        "--yes": yes,
        "--dead-man": dead_man,
    }
    paced = realtime and not emulate
    if not paced and (named := given_of(devices)):
        raise InputError(f"{' and '.join(named)}: of runs that keep pace with the clock.")
    if web and emulate:
        raise InputError("--emulate answers by itself: leave out --web.")
    if live_at is not None and not web:
        raise InputError("--live-at without --web: there is no page; add --web.")
    if hands and not (web and paced):
        raise InputError("--hands is for trials that a page shows while they go on: add --web.")
    options = RunOptions(
        figure=False,
        report=False,
        realtime=paced,
        cpu=cpu,
        enable_output=enable_output,
        yes=yes,
        dead_man=dead_man,
    )
    with ExitStack() as stack:
        own = stack.enter_context(ParticipantHands()) if hands else None
        runner = TrialRunner(study, options, say, own)
        boxes: Mapping[str, Path] = {} if own is None else own.mailboxes
        seat = seated(study, emulate=emulate, web=web, live_at=live_at, mailboxes=boxes, say=say)
        who, announce = stack.enter_context(seat)

        def show(trial: StudyTrial, folder: Path) -> Mapping[str, Any]:
            announce(f"Trial {trial.number} of {study.form.trials * len(study.form.conditions)}.")
            return runner(trial, folder)

        done = take_part(study, folder, participant, who, show, emulated=emulate, say=say)
    facts = {"participant": participant, "trials": done, "folder": str(folder.path)}
    if as_json:
        click.echo(json.dumps(facts))
    else:
        click.echo(f"{participant}: {done} trials, in {folder.of(participant)}")


@command.command("table", cls=JsonCommand)
@PLAN
@OUT
@click.option(
    "--table", "file", type=OutputFile((".csv", ".parquet")), help="Where the table is written."
)
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def table_command(*, plan: Path, out: Path | None, file: Path | None, as_json: bool) -> None:
    """Write a row for each trial of everybody, and say the thresholds."""
    from cosim.report.measures import SCENARIO_MEASURES
    from cosim.study.table import columns_of, rows_of, thresholds, units_of
    from cosim.sweep.results.table import write_columns

    study, folder = _opened(plan, out)
    rows = rows_of(folder)
    if not rows:
        raise InputError(f"{folder.path}: no trial is done yet.")
    file = folder.path / "trials.csv" if file is None else file
    measures = {name: measure.unit for name, measure in SCENARIO_MEASURES.items()}
    write_columns(columns_of(rows), units_of(study, measures), file)
    found = thresholds(study, folder)
    left_out = sum(bool(row["excluded"]) for row in rows)
    kinds = {row["emulated"] for row in rows}
    if as_json:
        plain = {c: {who: asdict(t) for who, t in by.items()} for c, by in found.items()}
        facts = {"table": str(file), "trials": len(rows), "excluded": left_out}
        click.echo(json.dumps({**facts, "thresholds": plain}))
        return
    click.echo(f"{file}: {len(rows)} trials, {left_out} of them excluded")
    if len(kinds) == 2 and found:
        click.echo("  what follows is of people; emulated participants are in the table alone")
    unit = study.form.staircase.unit if study.form.staircase else ""
    for condition, by_person in found.items():
        every = by_person["all"]
        click.echo(
            f"  {condition}: noticed in half of the trials at {every.value:.3g} {unit}".rstrip()
            + f" (95 %: {every.low:.3g} to {every.high:.3g}; {every.trials} trials of "
            f"{len(by_person) - 1} participants)"
        )


TRIAL = click.option("--trial", type=click.IntRange(1, 10**6), help="Only this. [default: all]")
BY = click.option("--by", metavar="NAME", help="Who decides it. [default: who is logged in]")


@command.command("exclude", cls=JsonCommand)
@PLAN
@click.argument("code")
@OUT
@TRIAL
@click.option("--reason", required=True, help="Why; it stands in the table.")
@BY
def exclude_command(
    *, plan: Path, code: str, out: Path | None, trial: int | None, reason: str, by: str | None
) -> None:
    """Leave participant CODE, or one trial, out of what is computed; nothing is deleted.

    'cohaptic study include' takes it back.
    """
    _, folder = _opened(plan, out)
    folder.exclude(code, trial, reason, _who(by))
    click.echo(f"{_part(code, trial)} is excluded: {reason}")


@command.command("include", cls=JsonCommand)
@PLAN
@click.argument("code")
@OUT
@TRIAL
@click.option("--reason", required=True, help="Why; it stands in exclusions.jsonl.")
@BY
def include_command(
    *, plan: Path, code: str, out: Path | None, trial: int | None, reason: str, by: str | None
) -> None:
    """Take back that participant CODE, or one trial, is left out; both entries are kept."""
    _, folder = _opened(plan, out)
    folder.include(code, trial, reason, _who(by))
    click.echo(f"{_part(code, trial)} is no longer excluded: {reason}")


def _part(code: str, trial: int | None) -> str:
    return code if trial is None else f"{code}, trial {trial}"


def _who(by: str | None) -> str:
    """Who decides: the name that is given, or that of the login."""
    if by is not None:
        return by
    import getpass

    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):  # a process without an entry for its user
        return ""


def _opened(plan: Path, out: Path | None) -> tuple[StudyPlan, StudyFolder]:
    from cosim.report.measures import SCENARIO_MEASURES
    from cosim.study.folder import StudyFolder
    from cosim.study.plan import read_study

    if not plan.is_file():
        raise InputError(f"there is no plan {plan}.")
    study = read_study(plan, SCENARIO_MEASURES)
    return study, StudyFolder(Path("studies") / study.name if out is None else out)
