"""``cohaptic station``: one workstation of a scenario, linked to the others over UDP."""

from __future__ import annotations

import json
import os
import signal
import sys
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.console import Console, ended
from cosim.cli.support.devices import output_options, refuse_without_devices
from cosim.cli.support.drawings import drawing_options
from cosim.cli.support.pace import miss_options, pace_of
from cosim.cli.support.page import live_page, page_options, scene_of
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.terminal.width import shown_width
from cosim.cli.support.values import OutputFolder, seconds

if TYPE_CHECKING:
    from cosim.cli.support.pace import Policy
    from cosim.link.wire.address import Address


@click.command("station", cls=JsonCommand)
@click.argument("scenario", shell_complete=scenario_names)
@click.option("--as", "own", required=True, metavar="STATION", help="Which station to run.")
@click.option(
    "--listen", default="127.0.0.1:47000", show_default=True, metavar="HOST:PORT", help="Own end."
)
@click.option(
    "--peer",
    "peers",
    multiple=True,
    metavar="[STATION=]HOST:PORT",
    help="Another station's end; once for each.",
)
@click.option(
    "--key",
    "keys",
    multiple=True,
    metavar="[STATION=]FILE",
    help="Key file of 'cohaptic keygen' for a peer; needed beyond this machine.",
)
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="Lay a file over it.")
@click.option("--set", "sets", multiple=True, metavar="A.B=C", help="Change one value.")
@click.option("--duration", metavar="TIME", help="Time to run, instead of the scenario's (s).")
@click.option(
    "--wait", type=seconds(zero=True), help="Seconds to wait for the others. [default: for ever]"
)
@click.option(
    "--realtime/--no-realtime",
    default=True,
    help="Ask the system for real-time scheduling (a station always runs in real time).",
)
@page_options
@click.option(
    "--play", is_flag=True, help="Let the page's pointer be the hand of this station's user."
)
@miss_options
@output_options
@click.option("--out", type=OutputFolder(), help="Folder for the run; new or empty.")
@drawing_options
@click.option("--json", "as_json", is_flag=True, help="Print the summary as one JSON object.")
def command(
    *,
    scenario: str,
    own: str,
    listen: str,
    peers: tuple[str, ...],
    keys: tuple[str, ...],
    overlays: tuple[str, ...],
    sets: tuple[str, ...],
    duration: str | None,
    wait: float | None,
    realtime: bool,
    live: bool,
    foxglove: bool,
    live_at: str | None,
    play: bool,
    on_miss: Policy | None,
    cpu: int | None,
    enable_output: bool,
    yes: bool,
    dead_man: str | None,
    out: Path | None,
    figure: bool,
    report: bool | None,
    as_json: bool,
) -> None:
    """Run one station of SCENARIO in real time; its channels become UDP links to the others.

    Start the same scenario on every machine, each with its own --as. The stations compare what
    they are about to run, agree on a start, and each records its own side.
    """
    from cosim.analysis.longest_delay import longest_delay
    from cosim.base.system.grants import clock_nanosleep
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.cli.support.devices import device_session, say
    from cosim.cli.support.hands import with_station_hands
    from cosim.link.wire.address import Address
    from cosim.live.mailbox import Mailbox
    from cosim.live.pointer import Pointer
    from cosim.reading import load
    from cosim.realtime.paced_run import PacedRun
    from cosim.station.run import Arrangement, run_station

    # A service manager's SIGTERM stops in order, too: the peer is told, the record is closed.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    if duration is not None:
        sets = (*sets, f"duration={duration}")
    if play:
        user, loaded = with_station_hands(scenario, overlays, sets, own)
    else:
        user, loaded = None, load(scenario, overlays, sets)
    refuse_without_devices(
        loaded, enable_output=enable_output, yes=yes, dead_man=dead_man, station=own
    )
    pace = pace_of(loaded, on_miss=on_miss, cpu=cpu)
    device_session(enable_output=enable_output, yes=yes, dead_man=dead_man)
    console = Console() if sys.stderr.isatty() else None
    arrangement = Arrangement(
        listen=Address.parse(listen, "--listen"),
        peers=_peers(peers),
        key_files={name: Path(file) for name, file in _by_station(keys, "--key").items()},
        execute=PacedRun(
            cpu=pace.cpu, real_time=realtime, say=say, console=console, about=scene_of
        ),
        policy=pace.on_miss,
        patience=wait,
        sleep=clock_nanosleep(),
        theory=longest_delay,
    )
    with ExitStack() as stack:
        boxes: dict[str, Mailbox] = {}
        if user is not None:
            boxes[own] = Mailbox.create()
            stack.callback(boxes[own].remove)
        stack.enter_context(
            live_page(
                live=live or play,
                live_at=live_at,
                wanted=str(os.getpid()),
                foxglove=foxglove,
                mailboxes={name: box.path for name, box in boxes.items()},
            )
        )
        stack.enter_context(ended(console))
        finished = run_station(
            loaded,
            own,
            arrangement,
            say=say,
            judge=DeviceJudge(realtime=True, output=enable_output),
            out=out,
            figure=figure,
            page=report,
            instances={} if user is None else {user.pointer: Pointer(boxes[own])},
        )
    if as_json:
        click.echo(json.dumps(finished.summary.content))
        click.echo(finished.summary.content["message"] or str(finished.folder), err=True)
    else:
        click.echo(finished.summary.text(shown_width()))
        if finished.summary.content["message"]:
            say(finished.summary.content["message"])
    sys.exit(finished.summary.status)


def _peers(given: tuple[str, ...]) -> dict[str, Address]:
    from cosim.link.wire.address import Address

    return {
        name: Address.parse(address, "--peer")
        for name, address in _by_station(given, "--peer").items()
    }


def _by_station(given: tuple[str, ...], option: str) -> dict[str, str]:
    """``station=value`` or ``value`` as a mapping; one without a name is that of ""."""
    from cosim.base.errors import InputError

    found: dict[str, str] = {}
    for text in given:
        name, equals, value = text.partition("=")
        name, value = (name, value) if equals else ("", text)
        if name in found:
            message = f"{option} {name or value} is given twice; write {option} STATION=..."
            raise InputError(message)
        found[name] = value
    return found
