"""``cohaptic device conform``: tries a board and its driver against every rule that they have."""

from __future__ import annotations

import json
import sys
from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.cli.device.options import FILE, JSON
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from hil.device.device import Device
    from hil.safety.permission import Permission
    from hil.setup.calibrate.turner import Turner
    from hil.setup.conform.rule import RuleResult

COLOURS = {"kept": "green", "broken": "red", "not tried": "yellow"}


@click.command("conform", cls=JsonCommand)
@click.argument("url")
@FILE
@click.option("--only", "only", multiple=True, metavar="RULE", help="This rule; repeatable.")
@click.option(
    "--seconds",
    type=seconds(),
    default=60.0,
    show_default=True,
    help="How long samples are counted.",
)
@click.option(
    "--enable-output",
    is_flag=True,
    help="Also try what needs the output stage on, at zero torque or next to it.",
)
@click.option("--yes", is_flag=True, help="Ask nobody: for an emulator that proves to be one.")
@JSON
def conform_device(
    url: str,
    file: Path | None,
    only: tuple[str, ...],
    seconds: float,
    *,
    enable_output: bool,
    yes: bool,
    as_json: bool,
) -> None:
    """Try the board at URL, and its driver, against every rule; the handle has to be free.

    Each rule is kept, broken, or was not tried, with the reason. Exit status 1: one is broken.
    """
    from cosim.cli.device.sensor import is_sensor, refuse_for_sensor, rules_of_sensor
    from cosim.cli.support.devices import open_device, person_or_emulator
    from hil.setup.conform.bench import ConformBench
    from hil.setup.conform.suite import RULES, chosen, conform
    from hil.wire.side_channel import Control

    if is_sensor(url):
        refuse_for_sensor(enable_output=enable_output, yes=yes)
        _tell(rules_of_sensor(url, file, only, seconds), as_json=as_json)
        return
    rules = chosen(only, RULES)
    with open_device(url, file) as device:
        ask = person_or_emulator(device, yes=yes)
        permission = _permission(device, yes=ask is None) if enable_output else None
    path = device.address.emulator if ask is None else None
    with nullcontext() if path is None else closing(Control(path)) as control:
        bench = ConformBench(
            kind=type(device.driver),
            address=device.address,
            file=device.file,
            turner=_turner(ask, path),
            ask=ask,
            control=control,
            permission=permission,
            seconds=seconds,
        )
        _tell(conform(bench, rules), as_json=as_json)


def _tell(found: Iterator[RuleResult], *, as_json: bool) -> None:
    """Show each rule's result as it comes; a broken one makes the exit status 1."""
    from dataclasses import asdict

    results: list[RuleResult] = []
    for result in found:
        results.append(result)
        if not as_json:
            mark = click.style(f"{result.outcome:10}", fg=COLOURS[result.outcome])
            why = f"\n{'':12}{result.sentence}" if result.sentence else ""
            click.echo(f"{mark}{result.name:10}{result.claim}{why}")
    if as_json:
        click.echo(json.dumps({"rules": [asdict(result) for result in results]}))
    if any(result.outcome == "broken" for result in results):
        sys.exit(1)


def _permission(device: Device, *, yes: bool) -> Permission | None:
    from cosim.cli.support.devices import device_session

    return device_session(enable_output=True, yes=yes).permission(device)


def _turner(ask: Callable[[str], str] | None, path: str | None) -> Turner:
    from hil.setup.calibrate.turner import AskedTurner, EmulatedTurner

    if ask is not None:
        return AskedTurner(ask)
    assert path is not None, "nobody is asked for an emulator alone"
    return EmulatedTurner(path)
