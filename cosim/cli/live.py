"""``cohaptic live``: watch a paced run from another process, without touching it."""

from __future__ import annotations

import json
import sys
import threading
import time
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number, seconds

if TYPE_CHECKING:
    from cosim.realtime.watcher import Watcher

USUAL = ("*.normal_force", "*.box_pose.x", "*.box_pose.y", "*.position*", "*.joint_angle*")
MOST = 4
"""Signals that are drawn where nobody says which."""
DRAW_SECONDS = 0.1
COLUMNS = 60


@click.command("live", cls=JsonCommand)
@click.argument("run", required=False)
@click.option("--show", "patterns", multiple=True, metavar="PATTERN", help="Signals to draw.")
@click.option(
    "--window",
    type=Number(0.01, 3600),
    default=5.0,
    show_default=True,
    help="Seconds of them to draw.",
)
@click.option(
    "--seconds", type=seconds(zero=True), help="How long to watch. [default: until the run ends]"
)
@click.option("--web", is_flag=True, help="Serve a page to watch it in, with its picture.")
@click.option("--foxglove", is_flag=True, help="Serve it for Foxglove, by its WebSocket protocol.")
@click.option(
    "--live-at",
    metavar="HOST:PORT",
    help="Where that is served. [default: 127.0.0.1, a free port]",
)
@click.option("--json", "as_json", is_flag=True, help="Print the newest status and stop.")
def command(
    *,
    run: str | None,
    patterns: tuple[str, ...],
    window: float,
    seconds: float | None,
    web: bool,
    foxglove: bool,
    live_at: str | None,
    as_json: bool,
) -> None:
    """Watch RUN (its folder, its scenario's name or its process) while it goes on.

    Without RUN, the newest 'cohaptic run --realtime' or 'cohaptic station' of this machine. It
    reads shared memory: the run is not slowed down, and what comes too fast is lost and counted.
    With --web a page shows it, and the next run after it, until Ctrl-C; with --foxglove Foxglove.
    """
    if web or foxglove:
        if patterns or as_json:
            raise InputError("--show and --json are for the terminal; the page has its own plots.")
        _serve(run, live_at, seconds, web=web, foxglove=foxglove)
        return
    if live_at is not None:
        raise InputError("--live-at without --web: there is no page; add --web.")
    from cosim.realtime.watcher import Watcher, find_feed

    with Watcher(find_feed(run)) as watcher:
        if as_json:
            click.echo(json.dumps(_facts(watcher)))
            return
        names = choose(list(watcher.signals()), patterns)
        watcher.watch(names)
        end = None if seconds is None else time.monotonic() + seconds
        if sys.stdout.isatty():
            _draw(watcher, names, window, end)
        else:
            _tell(watcher, end)


def _serve(
    run: str | None, live_at: str | None, seconds: float | None, *, web: bool, foxglove: bool
) -> None:
    """Serve the page, or for Foxglove, until Ctrl-C, or for so long.

    Raises:
        InputError: it cannot be served there.
    """
    from cosim.cli.support.page import live_page

    page = live_page(live=web, live_at=live_at, wanted=run, foxglove=foxglove)
    with page, suppress(KeyboardInterrupt):
        threading.Event().wait(seconds)


def choose(signals: Sequence[str], patterns: Sequence[str]) -> list[str]:
    """The signals that the patterns name; the usual ones where there are none.

    Raises:
        InputError: a pattern matches nothing.
    """
    if not patterns:
        usual = [name for p in USUAL for name in signals if fnmatchcase(name, p)]
        return list(dict.fromkeys(usual))[:MOST]
    from cosim.base.suggest import did_you_mean

    found: list[str] = []
    for pattern in patterns:
        matching = [name for name in signals if fnmatchcase(name, pattern)]
        if not matching:
            hint = did_you_mean(pattern, signals)
            raise InputError(f"the run records nothing like '{pattern}'.{hint}")
        found += matching
    return list(dict.fromkeys(found))


def _facts(watcher: Watcher) -> dict[str, Any]:
    from dataclasses import asdict

    status = watcher.status()
    content = {name: watcher.content[name] for name in ("name", "pid", "folder")}
    return {**content, "status": None if status is None else asdict(status)}


def _going_on(watcher: Watcher, end: float | None) -> bool:
    return watcher.running and (end is None or time.monotonic() < end)


def _tell(watcher: Watcher, end: float | None) -> None:
    """A line a second, for a log."""
    while _going_on(watcher, end):
        rows = max((len(values) for values in watcher.rows().values()), default=0)
        status = watcher.status()
        if status is not None:
            click.echo(f"{status.line()} | {rows} rows read, {watcher.lost} lost")
        time.sleep(1.0 if end is None else min(1.0, max(0.0, end - time.monotonic())))


def _draw(watcher: Watcher, names: list[str], window: float, end: float | None) -> None:
    from rich.console import Group
    from rich.live import Live
    from rich.text import Text

    from cosim.cli.support.plot import plot

    units = watcher.signals()
    kept: dict[str, deque[float]] = {}
    most = max(COLUMNS, round(window * float(watcher.content["rate"])))
    with Live(auto_refresh=False, screen=False) as screen:
        while _going_on(watcher, end):
            for name, values in watcher.rows().items():
                kept.setdefault(name, deque(maxlen=most)).extend(values.tolist())
            status = watcher.status()
            lines = [Text("waiting for the first tick" if status is None else status.line())]
            for name in names:
                width = min(COLUMNS, screen.console.width)
                shown = plot(name, units[name], kept.get(name, ()), width)
                lines += [Text(text) for text in shown]
            lines.append(Text(f"{watcher.lost} rows lost; Ctrl-C leaves the run alone", "dim"))
            screen.update(Group(*lines), refresh=True)
            time.sleep(DRAW_SECONDS)
