"""What the commands that run devices have in common: who is asked, and who is told."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from hil.session import Session


dead_man_option = click.option(
    "--dead-man",
    metavar="SOURCE",
    help="Force lasts only while this input is held: 'device', or evdev:/dev/input/eventN?key=57.",
)


def device_session(*, enable_output: bool, yes: bool, dead_man: str | None = None) -> Session:
    """Begin the session that the run's devices belong to; a terminal is where a person is asked.

    Raises:
        InputError: the dead-man input cannot be used.
    """
    from hil import session as sessions
    from hil.dead_man import open_dead_man

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
