"""``cohaptic intent``: fit the intent predictor to recorded hands, and say what it is worth."""

from __future__ import annotations

import json
import re
from contextlib import ExitStack
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.values import Number, OutputFile

if TYPE_CHECKING:
    from cosim.analysis.intent.filter import Tuning
    from cosim.analysis.intent.moves import Moves
    from cosim.record.reader import Run

SAID = re.compile(r"(.+\.(?:shared|up)\.finger_[12])_position\[([12])\]")
"""Where a workstation says where a finger is."""


@click.command("intent", cls=JsonCommand)
@click.argument(
    "runs",
    nargs=-1,
    required=True,
    type=click.Path(path_type=Path),
    shell_complete=run_folders,
)
@click.option(
    "--finger",
    "fingers",
    multiple=True,
    metavar="NAME",
    help="A finger as its station tells of it, such as vr_a.shared.finger_1.  [default: all]",
)
@click.option(
    "--network-rate",
    type=Number(1, 1e5),
    default=128.0,
    show_default=True,
    metavar="HZ",
    help="How often packets are sent.",
)
@click.option(
    "--out",
    type=OutputFile((".yaml", ".yml")),
    help="Write a file to lay over the scenario (--with), in which it is used.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    runs: tuple[Path, ...],
    *,
    fingers: tuple[str, ...],
    network_rate: float,
    out: Path | None,
    as_json: bool,
) -> None:
    """Fit the predictor 'intent' to the hands in RUNS, beside hold and linear at n = 2 to 6.

    The recordings are cut into pieces of 2 s: every other one is fitted to, the others are what
    the errors are of. Without --finger all fingers are used that packets tell of.
    """
    from cosim.analysis.intent.compare import errors
    from cosim.analysis.intent.filter import Tuning
    from cosim.analysis.intent.fit import fit

    moves, stations = _recorded(runs, fingers, Fraction(network_rate).limit_denominator(1000))
    known, unknown = moves.halves
    tuning = fit(known)
    found = errors(unknown, tuning)
    found["intent, as it comes"] = errors(unknown, Tuning.default())["intent"]
    if out is not None:
        with writing(out):
            out.write_text(overlay(tuning, stations), encoding="utf-8")
    if as_json:
        values = {name: getattr(tuning, name) for name in tuning.names}
        click.echo(json.dumps({"intent": values, "errors": found}))
        return
    click.echo("\n".join(_table(found)))
    best = min(("hold", "linear", "intent"), key=lambda name: sum(found[name].values()))
    click.echo(
        f"\nBest over all of them: {best}."
        + (
            ""
            if best == "intent"
            else f" Take predictor {'hold_last' if best == 'hold' else best}."
        )
    )
    click.echo("\n".join(f"intent.{name} = {getattr(tuning, name):.4g}" for name in tuning.names))


def _recorded(
    folders: tuple[Path, ...], fingers: tuple[str, ...], rate: Fraction
) -> tuple[Moves, list[str]]:
    """The hands in all runs, and the components that predict.

    Raises:
        InputError: a run is none, has no such finger, or its rate is no multiple of the network's.
    """
    import numpy as np

    from cosim.analysis.intent.moves import Moves, cut
    from cosim.record import open_run

    parts: list[Moves] = []
    stations: dict[str, None] = {}
    with ExitStack() as stack:
        for folder in folders:
            run = stack.enter_context(open_run(folder))
            names = _coordinates(run, fingers, folder)
            stations |= dict.fromkeys(_stations(run))
            first = run[names[0][0]]
            ratio = first.group.rate / rate
            if ratio.denominator != 1:
                raise InputError(
                    f"{folder}: {names[0][0]} is recorded at {float(first.group.rate):g} Hz, which "
                    f"is no multiple of --network-rate {float(rate):g}: say how often packets "
                    "were sent."
                )
            position = np.array([run[where].values for where, _ in names], dtype=float).T
            velocity = np.array([run[fast].values for _, fast in names], dtype=float).T
            parts.append(cut(position, velocity, 1 / first.group.rate, int(ratio)))
    if len({(part.period, part.ratio) for part in parts}) > 1:
        raise InputError("The runs have different rates: fit to each kind by itself.")
    one = parts[0]
    return Moves(
        np.hstack([part.position for part in parts]),
        np.hstack([part.velocity for part in parts]),
        one.period,
        one.ratio,
    ), list(stations)


def _coordinates(run: Run, fingers: tuple[str, ...], folder: Path) -> list[tuple[str, str]]:
    """Position and velocity of every coordinate that is wanted."""
    there: dict[str, list[tuple[str, str]]] = {}
    for name in run.signals:
        match = SAID.fullmatch(name)
        rate = name.replace("_position[", "_velocity[")
        if match and rate in run.signals:
            there.setdefault(match[1], []).append((name, rate))
    if not there:
        raise InputError(
            f"{folder} does not record what its stations say of fingers, such as "
            "vr_a.shared.finger_1_position[1]: record them, and their velocities."
        )
    for finger in fingers:
        if finger not in there:
            raise InputError(
                f"{folder} has no finger '{finger}'.{did_you_mean(finger, there)}"
                f" There are {', '.join(there)}."
            )
    return [pair for finger in fingers or there for pair in there[finger]]


def _stations(run: Run) -> list[str]:
    """The components of a run that take a predictor."""
    from cosim.reading import load

    takes = {"distributed_workstation", "central_server"}
    parts = load(run.scenario_file).components.items()
    return [name for name, part in parts if part.is_bundled and part.source in takes]


def overlay(tuning: Tuning, stations: list[str]) -> str:
    """A file to lay over a scenario in which every station predicts with this tuning."""
    values: Any = ", ".join(f"{name}: {getattr(tuning, name):.4g}" for name in tuning.names)
    lines = ["# Laid over the scenario: --with THIS.yaml", "components:"]
    for name in stations:
        lines += [
            f"  {name}:",
            "    parameters:",
            "      predictor: intent",
            f"      intent: {{{values}}}",
        ]
    return "\n".join(lines) + "\n"


def _table(found: dict[str, dict[int, float]]) -> list[str]:
    delays = list(found["hold"])
    lines = ["error, mm rms         " + "".join(f"   n = {delay}" for delay in delays)]
    for name, row in found.items():
        lines.append(f"{name:22}" + "".join(f"{1e3 * row[delay]:8.3f}" for delay in delays))
    return lines
