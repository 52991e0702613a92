"""What the commands that run devices have in common: who is asked, and who is told."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.effect import given_of, refuse_without

if TYPE_CHECKING:
    from cosim.scenario import Scenario
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
    has_devices = any(
        part.kind == "device" and station in (None, part.station)
        for part in scenario.components.values()
    )
    given = {"--enable-output": enable_output, "--yes": yes, "--dead-man": dead_man}
    if (named := given_of(given)) and not has_devices:
        where = f"the station {station}" if station is not None else scenario.name
        raise InputError(
            f"{' and '.join(named)}: {where} has no device; lay one over it with --with "
            f"devices/mock, or leave {'it' if len(named) == 1 else 'them'} out."
        )
    if not enable_output:
        refuse_without("--enable-output", given, "no force comes out that it could allow")


def say(sentence: str) -> None:
    """Show a sentence beside the command's output."""
    click.echo(sentence, err=True)


def ask_person(text: str) -> str:
    """What a person answers at the terminal; what was typed before the question is no answer.

    Raises:
        InputError: the command runs in the background, where it would answer for another.
    """
    import os
    import termios

    from cosim.base.errors import InputError

    terminal = sys.stdin.fileno()
    if os.tcgetpgrp(terminal) != os.getpgrp():
        raise InputError("a question has to be answered, and this runs in the background: use 'fg'")
    termios.tcflush(terminal, termios.TCIFLUSH)
    click.echo(text, err=True, nl=False)
    return sys.stdin.readline()
