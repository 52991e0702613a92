"""``cohaptic check``: read a scenario, load its FMUs, and report every problem in one go."""

from __future__ import annotations

import json
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError, InputErrors
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.effect import given_of
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.terminal.width import shown_width

if TYPE_CHECKING:
    from cosim.master.run.simulation import Simulation
    from cosim.scenario import Scenario

_INDENT: dict[str, Any] = {"initial_indent": "  ", "subsequent_indent": "  "}


@click.command("check", cls=JsonCommand)
@click.argument("scenarios", nargs=-1, metavar="[SCENARIO]...", shell_complete=scenario_names)
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="An overlay over it.")
@click.option("--set", "sets", multiple=True, metavar="PATH=VALUE", help="One value over it.")
@click.option("--resolved", is_flag=True, help="Print the scenario with every default in it.")
@click.option("--schema", is_flag=True, help="Print the JSON schema of scenario files.")
@click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout.")
def command(
    *,
    scenarios: tuple[str, ...],
    overlays: tuple[str, ...],
    sets: tuple[str, ...],
    resolved: bool,
    schema: bool,
    as_json: bool,
) -> None:
    """Read SCENARIO (a file or a bundled name), load its FMUs, report every problem in one go.

    Of several, those of all.
    """
    if schema:
        given = {"SCENARIO": scenarios, "--with": overlays, "--set": sets, "--resolved": resolved}
        if named := given_of(given):
            raise InputError(
                f"{' and '.join(named)} beside --schema: the schema is the same for every "
                "scenario; leave out one or the other."
            )
        from cosim.reading import FORMS
        from cosim.scenario.form.document import json_schema

        click.echo(json.dumps(json_schema(FORMS), indent=2))
        return
    if not scenarios:
        raise click.UsageError("name a scenario: a file, or a bundled one such as two_users_box.")
    if resolved and len(scenarios) > 1:
        raise InputError("--resolved prints one scenario; name a single one.")
    found: list[tuple[Scenario, dict[str, Any]]] = []
    problems: list[InputError] = []
    for scenario in scenarios:
        try:
            found.append(_check(scenario, overlays, sets))
        except InputErrors as several:
            problems += several.errors
        except InputError as error:
            problems.append(error)
    if problems:
        raise problems[0] if len(problems) == 1 else InputErrors(problems)
    reports = [{"ok": True, **report} for _, report in found]
    if resolved:
        from cosim.scenario.resolved import to_yaml

        click.echo(to_yaml(found[0][0]), nl=False)
    elif as_json:
        answer = reports[0] if len(reports) == 1 else {"ok": True, "scenarios": reports}
        click.echo(json.dumps(answer, indent=2))
    else:
        width = shown_width()
        click.echo("\n\n".join(_text(report, width) for report in reports))


def _check(
    scenario: str, overlays: tuple[str, ...], sets: tuple[str, ...]
) -> tuple[Scenario, dict[str, Any]]:
    """The loaded scenario and what there is to say about it."""
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.preparation.prepare import prepare
    from cosim.preparation.trial_start import try_to_start
    from cosim.reading import load
    from cosim.scenario.describe import describe
    from cosim.station.halves import refuse_unusable_halves

    loaded = load(scenario, overlays, sets)
    judge = DeviceJudge(output=None)
    prepared = prepare(loaded, judge=judge)
    with prepared.simulation as simulation:
        refuse_unusable_halves(simulation.assembly)
        try_to_start(simulation)
        facts = {**describe(loaded), **_plan(simulation), **judge.facts}
        return loaded, {**facts, "warnings": list(prepared.warnings)}


def _plan(simulation: Simulation) -> dict[str, Any]:
    """What follows from the FMUs: the order within a tick, packets, what lags, what is recorded."""
    from cosim.master.assembly.plan import Act

    assembly = simulation.assembly
    return {
        "order": [
            {"component": action.unit, "outputs": list(action.names), "period": action.period}
            for action in assembly.plan.every
            if action.act is Act.GET
        ],
        "packets": [
            {"name": bundle.name, "period": bundle.period, "values": len(bundle.entries)}
            for bundle in assembly.wiring.bundles
        ],
        "lagging": list(simulation.assembly.lagging),
        "notes": list(simulation.notes),
        "recorded": [
            {"group": group.name, "period": group.period, "signals": len(group.columns)}
            for group in simulation.groups
        ],
    }


def _text(report: dict[str, Any], width: int | None) -> str:
    from cosim.cli.support.check_devices import bus_rows, device_rows, limit_rows, proof_rows
    from cosim.report.quantities import fitted

    time = f"{report['duration']:g} s = {report['ticks']} ticks of 1/{report['base_rate']:g} s"
    if report["start_time"]:
        time = f"{time} from {report['start_time']:g} s on"
    lines = [report["title"] or report["name"], f"{time}, seed {report['seed']}"]
    rates = [[f"{n}", f"{r['rate']:g} Hz", _ticks(r["period"])] for n, r in report["rates"].items()]
    components = [
        [name, f"{part['kind']} {part['source']}", part["station"], _ticks(part["period"])]
        for name, part in report["components"].items()
    ]
    channels = [
        [name, f"{source} -> {target}", f"{channel['rate']:g} Hz", channel[way]["sentence"]]
        for name, channel in report["channels"].items()
        for way, (source, target) in (
            ("forward", channel["between"]),
            ("backward", channel["between"][::-1]),
        )
    ]
    packets = [
        [packet["name"], f"{packet['values']} values", f"every {_ticks(packet['period'])}"]
        for packet in report["packets"]
    ]
    recorded = [
        [group["group"], f"{group['signals']} signals", f"every {_ticks(group['period'])}"]
        for group in report["recorded"]
    ]
    for title, rows in (
        ("Rates", rates),
        ("Components", components),
        ("Channels", channels),
        ("Packets", packets),
        ("Recorded", recorded),
        ("Devices", device_rows(report)),
        ("Device files", proof_rows(report)),
        ("Limits of the devices", limit_rows(report)),
        ("CAN buses", bus_rows(report)),
    ):
        lines += ["", title, *_table(rows, width)] if rows else []
    order = " > ".join(stage["component"] for stage in report["order"])
    lines += (
        ["", "Evaluation order within a tick", *wrap(order, min(98, width or 98), **_INDENT)]
        if order
        else []
    )
    told = (("Lagging one step", "lagging"), ("Notes", "notes"), ("Warnings", "warnings"))
    for title, sentences in told:
        lines += ["", title, *(f"  {s}" for s in report[sentences])] if report[sentences] else []
    return fitted("\n".join(lines), width)


def _ticks(count: int) -> str:
    return "1 tick" if count == 1 else f"{count} ticks"


def _table(rows: list[list[str]], width: int | None) -> list[str]:
    """Rows in columns; as they come where columns would be wider than the terminal."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    if width is not None and 2 * len(widths) + sum(widths) > width:
        return ["  " + "  ".join(row) for row in rows]
    cells = ([cell.ljust(width) for cell, width in zip(row, widths, strict=True)] for row in rows)
    return ["  " + "  ".join(row).rstrip() for row in cells]
