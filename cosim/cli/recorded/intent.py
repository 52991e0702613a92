"""``cohaptic intent``: fit the intent predictor to recorded hands, and say what it is worth."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.base.system.writing import writing
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.terminal.complete import run_folders
from cosim.cli.support.values import Number, OutputFile

if TYPE_CHECKING:
    from cosim.analysis.intent.filter import Tuning
    from cosim.analysis.intent.moves import Moves
    from cosim.scenario import Scenario


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
    help="A finger that a station tells of, such as vr_a.finger_1.  [default: all]",
)
@click.option(
    "--network-rate",
    type=Number(1, 1e5),
    metavar="HZ",
    help="How often packets are sent.  [default: as often as the run's were]",
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
    network_rate: float | None,
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

    moves, scenarios = _recorded(runs, fingers, network_rate)
    known, unknown = moves.halves
    tuning = fit(known)
    found = errors(unknown, tuning)
    found["intent, as it comes"] = errors(unknown, Tuning.default())["intent"]
    if out is not None:
        text = overlay(tuning, _predicting(scenarios, tuning))
        with writing(out):
            out.write_text(text, encoding="utf-8")
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
    folders: tuple[Path, ...], wanted: tuple[str, ...], given: float | None
) -> tuple[Moves, list[tuple[Scenario, Path]]]:
    """The hands in all runs, and the scenarios that ran.

    Raises:
        InputError: a run is none, has no such finger, or its rate is no multiple of the network's.
    """
    import numpy as np

    from cosim.analysis.intent.moves import Moves, cut
    from cosim.cli.recorded.told_fingers import packet_rate, told_fingers
    from cosim.reading import load
    from cosim.record import open_run

    parts: list[Moves] = []
    scenarios: list[tuple[Scenario, Path]] = []
    for folder in folders:
        with open_run(folder) as run:
            fingers = told_fingers(run, wanted)
            scenarios.append((load(run.scenario_file), folder))
            rate = (
                packet_rate(scenarios[-1][0], fingers, folder)
                if given is None
                else Fraction(given).limit_denominator(1000)
            )
            rows = fingers[0].rate
            ratio = rows / rate
            if ratio.denominator != 1:
                raise InputError(
                    f"{folder}: {fingers[0].name} is recorded at {float(rows):g} Hz, which is no "
                    f"multiple of --network-rate {float(rate):g}: say how often packets were sent."
                )
            moves = [finger.moves() for finger in fingers]
            position, velocity = (np.hstack([each[order] for each in moves]) for order in (0, 1))
            parts.append(cut(position, velocity, 1 / rows, int(ratio)))
    if len({(part.period, part.ratio) for part in parts}) > 1:
        raise InputError("The runs have different rates: fit to each kind by itself.")
    one = parts[0]
    return Moves(
        np.hstack([part.position for part in parts]),
        np.hstack([part.velocity for part in parts]),
        one.period,
        one.ratio,
    ), scenarios


def _predicting(scenarios: list[tuple[Scenario, Path]], tuning: Tuning) -> dict[str, str]:
    """The components of all runs that take a predictor, and what that parameter is called."""
    from cosim.cli.recorded.told_fingers import predicting

    found: dict[str, str] = {}
    for scenario, folder in scenarios:
        found |= predicting(scenario, folder, tuning.names)
    return found


def overlay(tuning: Tuning, stations: Mapping[str, str]) -> str:
    """A file to lay over a scenario in which every station predicts with this tuning.

    ``stations`` maps each to what its predictor is called.
    """
    values: Any = ", ".join(f"{name}: {getattr(tuning, name):.4g}" for name in tuning.names)
    lines = ["# Laid over the scenario: --with THIS.yaml", "components:"]
    for name, predictor in stations.items():
        lines += [
            f"  {name}:",
            "    parameters:",
            f"      {predictor}: intent",
            f"      intent: {{{values}}}",
        ]
    return "\n".join(lines) + "\n"


def _table(found: dict[str, dict[int, float]]) -> list[str]:
    delays = list(found["hold"])
    lines = ["error, mm rms         " + "".join(f"   n = {delay}" for delay in delays)]
    for name, row in found.items():
        lines.append(f"{name:22}" + "".join(f"{1e3 * row[delay]:8.3f}" for delay in delays))
    return lines
