"""``cohaptic device``: find devices, look at them safely, home, calibrate, emulate."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import click

from cosim.cli.device.calibrate import calibrate_device
from cosim.cli.device.check import check_device
from cosim.cli.device.conform import conform_device
from cosim.cli.device.emulate import emulate_device
from cosim.cli.device.first import first_power_on
from cosim.cli.device.options import FILE, JSON
from cosim.cli.support.command import JsonCommand


@click.group("device", context_settings={"help_option_names": ["-h", "--help"]})
def command() -> None:
    """Real devices: find them, look at them, home, calibrate and emulate them."""


@command.command("list", cls=JsonCommand)
@JSON
def list_drivers(*, as_json: bool) -> None:
    """List the drivers that are installed."""
    from cosim.base.errors import InputError
    from hil.setup.registry import find, names

    found: dict[str, dict[str, Any]] = {}
    for name in names():
        try:
            kind = find(name)
        except InputError as error:
            found[name] = {"problem": str(error)}
            continue
        found[name] = {
            "description": (sys.modules[kind.__module__].__doc__ or "").strip().splitlines()[0],
            "latency_ticks": kind.latency_ticks,
            "tested_on_hardware": kind.tested_on_hardware,
            "emulated": kind.emulator is not None,
            "command_unit": kind.command_unit,
            "measures_only": kind.measures_only,
            "presets": kind.preset_names(),
        }
    if as_json:
        click.echo(json.dumps(found))
        return
    for name, facts in found.items():
        click.echo(f"{name:14}{facts.get('problem') or facts['description']}")


@command.command("find", cls=JsonCommand)
@click.option("--scan", is_flag=True, help="Also listen for nodes on each CAN interface.")
@JSON
def find_ports(*, scan: bool, as_json: bool) -> None:
    """Show serial ports and CAN interfaces that a device could be on.

    Ports have names that stay the same (by-id) where the system gives them. With --scan each CAN
    interface is listened to for half a second; nothing is sent.
    """
    from hil.setup.search import candidates, nodes

    found = candidates() + (nodes() if scan else [])
    if as_json:
        click.echo(json.dumps({"candidates": found}))
        return
    if not found:
        click.echo("No serial port and no CAN interface was found.")
    for place in found:
        click.echo(f"{place['url']:40}{place['description']}")


@command.command("home", cls=JsonCommand)
@click.argument("url")
@FILE
@click.option("--yes", is_flag=True, help="Ask nobody: for an emulator that proves to be one.")
def home_device(url: str, file: Path | None, *, yes: bool) -> None:
    """Take the present pose of the device at URL as the home pose, and show where the tip is."""
    from cosim.cli.support.devices import open_device, person_or_emulator

    with open_device(url, file) as device:
        ask = person_or_emulator(device, yes=yes)
        if ask is not None:
            ask(f"Hold the handle of {device.name} at its home pose and press Enter: ")
        device.home()
        angle = device.read(0).joint_angle
        tip = device.file.linkage.tip(angle)
    assert tip is not None, "homing has checked the pose"
    click.echo(
        f"homed at {angle[0]:.4f} and {angle[1]:.4f} rad, tip at {tip[0] * 1e3:.1f}, "
        f"{tip[1] * 1e3:.1f} mm; a device keeps this only until its port is opened again"
    )


for each in (calibrate_device, check_device, conform_device, emulate_device, first_power_on):
    command.add_command(each)
