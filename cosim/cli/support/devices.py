"""What the commands that run devices have in common: who is asked, and who is told."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.effect import given_of, refuse_without
from cosim.cli.support.shown import shown

if TYPE_CHECKING:
    from pathlib import Path

    from cosim.scenario import Scenario
    from hil.device.device import Device
    from hil.setup.session import Session

Command = Callable[..., Any]


def output_options(command: Command) -> Command:
    """The options of a command that runs devices: where its loop runs, and who allows force."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


_OPTIONS: tuple[Callable[[Command], Command], ...] = (
    click.option(
        "--cpu",
        type=click.IntRange(0, (os.cpu_count() or 1) - 1),
        help="Processor for the control loop. [default: a little used one]",
    ),
    click.option(
        "--enable-output",
        is_flag=True,
        help="Let devices produce force; without it the torque is computed and zero is sent.",
    ),
    click.option(
        "--dead-man",
        metavar="SOURCE",
        help="Force lasts only while this input is held: 'device', or "
        "evdev:/dev/input/eventN?key=57.",
    ),
    click.option(
        "--yes", is_flag=True, help="Confirm the output of emulators that prove to be ones."
    ),
)


def device_session(*, enable_output: bool, yes: bool, dead_man: str | None = None) -> Session:
    """Begin the session that the run's devices belong to; a terminal is where a person is asked.

    Raises:
        InputError: the dead-man input cannot be used.
    """
    from hil.safety.dead_man import open_dead_man
    from hil.setup import session as sessions

    return sessions.begin(
        sessions.Session(
            enable_output=enable_output,
            yes=yes,
            dead_man=None if dead_man is None else open_dead_man(dead_man),
            prompt=ask_person if sys.stdin.isatty() else None,
            say=say,
        )
    )


def refuse_without_devices(
    scenario: Scenario,
    *,
    enable_output: bool,
    yes: bool,
    dead_man: str | None,
    station: str | None = None,
) -> None:
    """Refuse options that act on devices alone.

    Raises:
        InputError: one was given where no device runs, or nothing that it could act on.
    """
    given = {"--enable-output": enable_output, "--yes": yes, "--dead-man": dead_man}
    named = given_of(given)
    if named and not any(
        part.kind == "device" and station in (None, part.station) and _pushes(part.source)
        for part in scenario.components.values()
    ):
        where = f"the station {station}" if station is not None else scenario.name
        raise InputError(
            f"{' and '.join(named)}: {where} has no device that pushes; lay one over it "
            f"with --with devices/mock, or leave {'it' if len(named) == 1 else 'them'} out."
        )
    if not enable_output:
        refuse_without("--enable-output", given, "no force comes out that it could allow")


def _pushes(url: str) -> bool:
    """Whether there is an output behind a URL; one that is wrong is refused at its own place."""
    from hil.setup.address import parse
    from hil.setup.registry import find

    try:
        return not find(parse(url).driver).measures_only
    except InputError:
        return True


def open_device(url: str, file: Path | None) -> Device:
    """A configured device; without a file it is what its maker sells.

    Raises:
        DeviceError: it does not answer.
        InputError: URL or file cannot be used.
    """
    from hil.device.device import Device
    from hil.device.driver import find_driver
    from hil.setup.address import parse
    from hil.setup.device_file import default, load

    address = parse(url)
    kind = find_driver(address.driver)
    device = Device(kind, address, load(file) if file is not None else default(kind.driver))
    device.configure()
    return device


def person_or_emulator(device: Device, *, yes: bool) -> Callable[[str], str] | None:
    """Who is asked about a configured device: a person, or nobody where it is an emulator.

    Raises:
        ActivationRefused: nobody is at a terminal, or shall be asked, and it may be a real device.
    """
    from hil.device.errors import ActivationRefused
    from hil.setup.session import doubt_of

    if sys.stdin.isatty() and not yes:
        return ask_person
    doubt = doubt_of(device)
    if doubt is not None:
        why = "--yes asks nobody" if yes else "nobody is at a terminal"
        raise ActivationRefused(
            f"{why}, and {device.name} did not prove to be an emulator ({doubt}): a person has to "
            "hold and look at a real device"
        )
    return None


def say(sentence: str) -> None:
    """Show a sentence beside the command's output."""
    shown.say(sentence)


def ask_person(text: str) -> str:
    """What a person answers at the terminal; what was typed before the question is no answer.

    Raises:
        InputError: the command runs in the background, where it would answer for another.
    """
    import os
    import termios

    from cosim.base.errors import InputError

    descriptor = sys.stdin.fileno()
    if os.tcgetpgrp(descriptor) != os.getpgrp():
        raise InputError("a question has to be answered, and this runs in the background: use 'fg'")
    termios.tcflush(descriptor, termios.TCIFLUSH)
    click.echo(text, err=True, nl=False)
    return sys.stdin.readline()
