"""What the commands that run devices have in common: who is asked, and who is told."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from hil.setup.session import Session

Command = Callable[..., Any]


def output_options(command: Command) -> Command:
    """The options of a command that runs devices: where its loop runs, and who allows force."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


_OPTIONS: tuple[Callable[[Command], Command], ...] = (
    click.option(
        "--cpu", type=int, help="Processor for the control loop. [default: a little used one]"
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
            prompt=_prompt if sys.stdin.isatty() else None,
            say=say,
        )
    )


def say(sentence: str) -> None:
    """Show a sentence beside the command's output."""
    click.echo(sentence, err=True)


def _prompt(text: str) -> str:
    click.echo(text, err=True, nl=False)
    return sys.stdin.readline()
