"""``cohaptic play``: take a user's place in a scenario, by hand, in a browser."""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import click

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.console import Console, ended
from cosim.cli.support.page import ANYWHERE, scene_of
from cosim.cli.support.terminal.complete import scenario_names
from cosim.cli.support.terminal.width import shown_width
from cosim.cli.support.values import OutputFolder

if TYPE_CHECKING:
    from cosim.base.component import Component
    from cosim.live.control import PlayControl
    from cosim.live.hands import User
    from cosim.live.knobs.page_knob import PageKnob
    from cosim.realtime.live import Feed
    from cosim.realtime.paced_run import PacedRun
    from cosim.run import Finished
    from cosim.scenario import Scenario

DURATION = "2 min"
LOOK_SECONDS = 0.1


@click.command("play", cls=JsonCommand)
@click.argument("scenario", default="two_users_box_switched", shell_complete=scenario_names)
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="Lay a file over it.")
@click.option(
    "--set",
    "sets",
    multiple=True,
    metavar="A.B=C",
    help="Change one value, such as channels.lan.round_trip_delay=2; may be repeated.",
)
@click.option("--duration", metavar="TIME", help=f"How long a take lasts. [default: {DURATION}]")
@click.option(
    "--out", type=OutputFolder(), help="Folder of the first take. [default: runs/<scenario>-<n>]"
)
@click.option(
    "--live-at",
    metavar="HOST:PORT",
    help="Where the page is served. [default: 127.0.0.1, a free port]",
)
@click.option(
    "--again",
    is_flag=True,
    help="SCENARIO is the folder of a take: run it again with its hands, as fast as it goes.",
)
@click.option("--browser/--no-browser", default=True, help="Open the page in a browser.")
def command(
    *,
    scenario: str,
    overlays: tuple[str, ...],
    sets: tuple[str, ...],
    duration: str | None,
    out: Path | None,
    live_at: str | None,
    again: bool,
    browser: bool,
) -> None:
    """Play in SCENARIO: a page shows it, and your pointer moves a user's fingers.

    Move over the box, hold the button to pinch it, and carry it; a second page is the second user.
    Every take is recorded; --again runs one again, with the same digest where nothing is changed.
    Ctrl-C ends it.
    """
    if again:
        if live_at is not None or duration is not None:
            raise InputError("--again runs a take as it was: leave out --live-at and --duration.")
        _again(Path(scenario), overlays, sets, out)
    from cosim.cli.support.devices import refuse_without_devices, say
    from cosim.cli.support.play_theory import theory_of
    from cosim.live.access import listening
    from cosim.live.control import PlayControl
    from cosim.live.knobs.page_knob import places
    from cosim.live.mailbox import Mailbox
    from cosim.live.panel import KNOBS, KnobPanel
    from cosim.live.pointer import Pointer
    from cosim.live.process import ServerProcess
    from cosim.realtime.ring import Ring

    lasting = f"duration={duration or DURATION}"
    users, knobs, loaded = _with_hands(scenario, overlays, sets, lasting)
    refuse_without_devices(loaded, enable_output=False, yes=False, dead_man=None)
    with ExitStack() as stack:
        control = PlayControl.create()
        stack.callback(control.remove)
        boxes: dict[str, Mailbox] = {}
        for user in users:
            boxes[user.station] = Mailbox.create()
            stack.callback(boxes[user.station].remove)
        rings: dict[str, Ring] = {}
        for station in places(knobs):
            rings[station] = Ring.create(KNOBS, capacity=16, what="the knobs of a page")
            stack.callback(rings[station].remove)
        server = stack.enter_context(
            ServerProcess(
                listening(live_at or ANYWHERE),
                str(os.getpid()),
                mailboxes={user: box.path for user, box in boxes.items()},
                control=control.path,
                panels={station: ring.path for station, ring in rings.items()},
                knobs=knobs,
                theory=theory_of(loaded, knobs),
            )
        )
        address = server.address()
        say(f"play at: {address}")
        if browser:
            _open(address)

        def instances() -> dict[str, Component]:
            """Of one take: a component begins anew with it."""
            return {
                **{user.pointer: Pointer(boxes[user.station]) for user in users},
                **{f"panel_{station}": KnobPanel(ring) for station, ring in rings.items()},
            }

        finished = _takes(loaded, instances, control, out)
    if finished is not None and finished.error is not None:
        click.echo(str(finished.error), err=True)
        sys.exit(finished.error.exit_status)


def _again(
    take: Path, overlays: tuple[str, ...], sets: tuple[str, ...], out: Path | None
) -> NoReturn:
    """Run a take again: what its pointers showed comes from its record.

    Raises:
        InputError: it is no take.
    """
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.cli.support.devices import say
    from cosim.cli.support.run.child import run_in_child
    from cosim.live.hands import pointers_of
    from cosim.reading import load
    from cosim.record.reader import SCENARIO_FILE, open_run

    with open_run(take) as run:
        seconds = run.ticks / run.base_rate
    written = take / SCENARIO_FILE
    played = {name: {"playback": str(take.resolve())} for name in pointers_of(load(written))}
    with tempfile.TemporaryDirectory() as folder:
        hands = Path(folder) / "hands.yaml"
        hands.write_text(json.dumps({"components": played}), encoding="utf-8")
        lasting = f"duration={float(seconds)!r}"
        loaded = load(written, (hands, *overlays), (lasting, *sets))
    judge = DeviceJudge(realtime=False)
    finished = run_in_child(
        loaded, out, progress=None, figure=True, page=True, judge=judge, say=say
    )
    click.echo(finished.summary.text(shown_width()))
    if finished.summary.content["message"]:
        click.echo(finished.summary.content["message"], err=True)
    sys.exit(finished.summary.status)


def _with_hands(
    scenario: str, overlays: tuple[str, ...], sets: tuple[str, ...], lasting: str
) -> tuple[list[User], list[PageKnob], Scenario]:
    """Who can be played, what can be turned, and the scenario with pointers and panels in it.

    It lasts as long as the take only when people have taken over what it turns itself.

    Raises:
        InputError: it cannot be read, or nobody can be played.
    """
    from cosim.cli.support.hands import laid_over
    from cosim.live.hands import users_of, with_hands
    from cosim.live.knobs.found import knobs_of
    from cosim.live.knobs.overlay import others_events, with_panels
    from cosim.reading import load

    emulated = load(scenario, overlays, sets)
    users, knobs = users_of(emulated), knobs_of(emulated)
    documents = {"hands": with_hands(emulated, users), "panels": with_panels(emulated, knobs)}
    events = f"events={json.dumps(others_events(emulated, knobs))}"
    return users, knobs, laid_over(scenario, overlays, documents, (*sets, lasting, events))


def _takes(
    loaded: Scenario,
    instances: Callable[[], dict[str, Component]],
    control: PlayControl,
    out: Path | None,
) -> Finished | None:
    """One take after the other, as often as the page asks for a fresh start; the last one."""
    from cosim.cli.support.devices import say

    finished, number = None, 0
    with _until_interrupted():
        while True:
            control.look()
            begun, number = control.restarts, number + 1
            folder = out if out is None or number == 1 else out.with_name(f"{out.name}-{number}")
            finished = _take(loaded, instances(), control, folder)
            say(f"recorded in {finished.folder}")
            control.look()
            if control.restarts != begun:
                continue
            interrupted = finished.summary.content["message"] and finished.error is None
            if interrupted or finished.error is not None:
                return finished
            say("The take is over; 'Restart' on the page begins another, Ctrl-C ends this.")
            while control.restarts == begun:
                time.sleep(LOOK_SECONDS)
                control.look()
    return finished


def _take(
    loaded: Scenario,
    instances: Mapping[str, Component],
    control: PlayControl,
    out: Path | None,
) -> Finished:
    from cosim.base.system.grants import clock_nanosleep
    from cosim.cli.support.check_devices import DeviceJudge
    from cosim.cli.support.devices import say
    from cosim.live.play_pacer import PlayPacer
    from cosim.realtime.paced_run import PacedRun
    from cosim.realtime.pacing import DeadlinePacer
    from cosim.run import run_scenario

    paced = PacedRun(say=say, about=scene_of)
    tick = DeadlinePacer(tick_seconds=1 / loaded.base_rate, sleep=clock_nanosleep())
    paced.pacer = PlayPacer(tick, control, paced.pulse)
    console = _Listener(control, paced, Console() if sys.stderr.isatty() else None)
    paced.console = console
    with ended(console.line):
        return run_scenario(
            loaded,
            out,
            execute=paced,
            deadlines=paced.statistics,
            figure=False,
            instances=instances,
            judge=DeviceJudge(realtime=True),
            say=say,
        )


class _Listener:
    """Called some fifty times a second: ends the take where a fresh start is asked for."""

    def __init__(self, control: PlayControl, paced: PacedRun, line: Console | None) -> None:
        self._control, self._paced, self.line = control, paced, line
        self._begun = control.restarts

    def __call__(self, feed: Feed) -> None:
        """Look, and show the console's line."""
        self._control.look()
        if self._control.restarts != self._begun:
            self._paced.pulse.ask_to_stop()
        if self.line is not None:
            self.line(feed)


@contextmanager
def _until_interrupted() -> Generator[None]:
    """Ctrl-C between two takes is the end that was meant."""
    try:
        yield
    except KeyboardInterrupt:
        return


def _open(address: str) -> None:
    import webbrowser

    webbrowser.open(address)
