"""``cohaptic device first``: a board's first power-on, step by step, each one asked for."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.cli.device.calibrate import calibrate_device
from cosim.cli.device.check import check_device
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number, OutputFile

if TYPE_CHECKING:
    from collections.abc import Callable

NEXT = """\
{file} is complete. Now run dry, and look at what would have been pushed:
  cohaptic run SCENARIO --realtime
and then with force, a foot on a pedal and a low limit (limits: {{torque: 0.03}} in {file}):
  cohaptic run SCENARIO --realtime --enable-output --dead-man evdev:/dev/input/by-id/...
"""


@click.command("first", cls=JsonCommand)
@click.argument("url")
@click.argument("file", type=OutputFile())
@click.option("--home", nargs=2, type=Number(-13, 13), help="Joint angles of the home pose (rad).")
@click.option("--estop", is_flag=True, help="You have a switch that cuts the motors' power.")
@click.option("--yes", is_flag=True, help="Ask nobody: for an emulator that proves to be one.")
@click.pass_context
def first_power_on(
    context: click.Context,
    url: str,
    file: Path,
    home: tuple[float, float] | None,
    *,
    estop: bool,
    yes: bool,
) -> None:
    """Lead through the first power-on of the device at URL, and write its device file FILE.

    The machine, the encoders without the motors' supply, the home pose, the watchdog, and each
    motor's sign with a tiny torque: every step says what it wants, and a step that fails ends it.
    """
    from cosim.base.errors import RunError
    from cosim.cli.support.devices import open_device, person_or_emulator
    from hil.setup.doctor.machine import machine_notes

    wrong = [note.sentence for note in machine_notes() if note.health == "bad"]
    if wrong:
        raise RunError(f"this machine is not fit for force yet: {'; '.join(wrong)}")
    with open_device(url, file if file.exists() else None) as device:
        ask = person_or_emulator(device, yes=yes)
        has_watchdog = device.watchdog.timeout is not None
    _step(ask, 1, "The motors' supply is off. Each joint is turned, and the file is written.")
    context.invoke(calibrate_device, url=url, output=file, home=home, estop=estop, yes=yes)
    _step(ask, 2, "Still without supply: move the handle about for five seconds.")
    context.invoke(check_device, url=url, file=file, seconds=5.0)
    if has_watchdog:
        _step(ask, 3, "Switch the supply on, your hand on its switch, and let go of the handle.")
        context.invoke(check_device, url=url, file=file, seconds=1.0, enable_output=True, yes=yes)
    _step(ask, 4, "Nobody holds the handle: each motor pushes its joint by a degree.")
    context.invoke(calibrate_device, url=url, output=file, enable_output=True, yes=yes)
    click.echo(NEXT.format(file=file), nl=False)


def _step(ask: Callable[[str], str] | None, number: int, what: str) -> None:
    """Say what comes, and wait for the person who does it."""
    click.echo(f"Step {number}: {what}", err=True)
    if ask is not None:
        ask("Press Enter when it is so: ")
