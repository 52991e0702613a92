"""What the commands that run devices have in common: who is asked, and who is told."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from hil.session import Session


def device_session(*, enable_output: bool, yes: bool) -> Session:
    """Begin the session that the run's devices belong to; a terminal is where a person is asked."""
    from hil import session as sessions

    return sessions.begin(
        sessions.Session(
            enable_output=enable_output,
            yes=yes,
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
