"""``--live`` and ``--foxglove``: the live page beside a run, served by a process of its own."""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError

if TYPE_CHECKING:
    from cosim.master.run.simulation import Simulation

Command = Callable[..., Any]
ANYWHERE = "127.0.0.1:0"
"""Loopback, and a port that is free."""


def page_options(command: Command) -> Command:
    """``--live``, ``--foxglove`` and ``--live-at``."""
    command = click.option(
        "--live-at",
        metavar="HOST:PORT",
        help="Where that is served. [default: 127.0.0.1, a free port]",
    )(command)
    command = click.option(
        "--foxglove", is_flag=True, help="Serve the run for Foxglove, by its WebSocket protocol."
    )(command)
    return click.option("--live", is_flag=True, help="Serve a page to watch the run in.")(command)


@contextmanager
def live_page(
    *,
    live: bool,
    live_at: str | None,
    wanted: str | None,
    foxglove: bool = False,
    mailboxes: Mapping[str, Path] | None = None,
) -> Generator[None]:
    """The page of the run that ``wanted`` names, while it goes on, or what Foxglove connects to.

    Nothing without ``live`` and ``foxglove``.

    ``mailboxes`` are those of the users whose hands it may move.

    Raises:
        InputError: it cannot be served there, or is asked to be served nowhere.
    """
    if not live and not foxglove:
        if live_at is not None:
            raise InputError("--live-at without --live: there is no page; add --live.")
        yield
        return
    from cosim.cli.support.devices import say
    from cosim.live.access import listening
    from cosim.live.process import ServerProcess

    where = listening(live_at or ANYWHERE)
    with ServerProcess(where, wanted, mailboxes=mailboxes, foxglove=foxglove) as server:
        page = server.address()
        if live:
            say(f"{'play at' if mailboxes else 'live page'}: {page}")
        if foxglove:
            say(f"Foxglove connects to: {server.foxglove_address}")
        yield


def scene_of(simulation: Simulation) -> Mapping[str, Any]:
    """What who watches is told besides the signals."""
    from cosim.scene import describe_scene

    return {"scene": describe_scene(simulation.assembly, simulation.groups)}
