"""``cohaptic device calibrate``: edits a device file by what is measured, and asks first."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number, OutputFile

if TYPE_CHECKING:
    from collections.abc import Callable

    from hil.device.device import Device
    from hil.setup.calibrate.turner import Turner
    from hil.setup.device_edit import Calibrated, Edit
    from hil.setup.driver_facts import DriverFacts

WORD = "write"
"""What a person types to have a device file written."""


@click.command("calibrate", cls=JsonCommand)
@click.argument("url")
@click.argument("output", type=OutputFile())
@click.option(
    "--file",
    type=click.Path(path_type=Path),
    help="The device file that a new one is begun from. [default: the maker's values]",
)
@click.option(
    "--home",
    nargs=2,
    type=Number(-13, 13),
    help="Joint angles of the home pose (rad). [default: the file's]",
)
@click.option("--serial", help="The device's serial number, to refuse another one later.")
@click.option("--estop", is_flag=True, help="You have a switch that cuts the motors' power.")
@click.option(
    "--enable-output",
    is_flag=True,
    help="Then also push each joint, with a tiny torque, to see which way its motor pushes.",
)
@click.option("--yes", is_flag=True, help="Ask nobody: for an emulator that proves to be one.")
def calibrate_device(
    url: str,
    output: Path,
    file: Path | None,
    home: tuple[float, float] | None,
    serial: str | None,
    *,
    estop: bool,
    enable_output: bool,
    yes: bool,
) -> None:
    """Edit the device file OUTPUT by what the device at URL shows, or begin a new one.

    You turn each joint, which tells the encoders' directions. What is not measured stays as it is
    written, comments included; the difference is shown, and written once you have agreed. With
    --enable-output each motor pushes its joint for a moment afterwards, and its sign is put right
    as well: the handle has to be free then.
    """
    from datetime import UTC, datetime

    from cosim.base.errors import InputError
    from hil.setup.calibrate.directions import directions
    from hil.setup.device_edit import Calibrated
    from hil.setup.device_file import load

    base = output if output.exists() else file
    if home is None and (base is None or load(base).home is None):
        raise InputError(
            "--home: give the joint angles of the pose in which the handle is held when it is "
            f"homed; {'no device file' if base is None else base} says none"
        )
    today = datetime.now(UTC).date().isoformat()
    with _opened(url, base) as device:
        ask = _asks(device, yes=yes)
        found = Calibrated(
            date=today,
            directions=directions(device, _turner(device, ask)),
            home=home,
            serial=serial or device.driver.serial(),
            estop=estop,
        )
    kind = type(device.driver)
    _agree(output, file, kind, found, ask)
    if enable_output:
        from cosim.cli.support.devices import device_session
        from cosim.cli.support.sign_check import torque_signs

        device_session(enable_output=True, yes=ask is None)
        signs = torque_signs(url, output)
        for joint, sign in enumerate(signs):
            way = "the way it should" if sign > 0 else "the other way"
            click.echo(f"the motor of joint {joint + 1} pushes {way}", err=True)
        _agree(output, None, kind, Calibrated(date=today, torque_signs=signs), ask)


def _opened(url: str, file: Path | None) -> Device:
    from cosim.cli.support.devices import open_device

    return open_device(url, file)


def _asks(device: Device, *, yes: bool) -> Callable[[str], str] | None:
    from cosim.cli.support.devices import person_or_emulator

    return person_or_emulator(device, yes=yes)


def _turner(device: Device, ask: Callable[[str], str] | None) -> Turner:
    """The person who can be asked, or the hand of the emulator that has proved itself."""
    from hil.setup.calibrate.turner import AskedTurner, EmulatedTurner

    if ask is not None:
        return AskedTurner(ask)
    path = device.address.emulator
    assert path is not None, "nobody is asked for an emulator alone"
    return EmulatedTurner(path)


def _agree(
    output: Path,
    base: Path | None,
    kind: type[DriverFacts],
    found: Calibrated,
    ask: Callable[[str], str] | None,
) -> Edit:
    """Show what would change, and write it once that is agreed to.

    Raises:
        InputError: it was not.
    """
    from cosim.base.errors import InputError
    from hil.setup.device_edit import calibrated

    edit = calibrated(output, base, kind, found)
    if not edit.difference:
        click.echo(f"{output} says so already")
        return edit
    click.echo(edit.difference, nl=False)
    if ask is not None and ask(f"Type '{WORD}' to write this to {output}: ").strip() != WORD:
        raise InputError(f"{output} stays as it was: the difference was not agreed to")
    edit.write()
    click.echo(f"wrote {output}")
    return edit
