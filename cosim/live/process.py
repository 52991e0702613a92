"""The server in a process of its own, beside the one that records; it ends with that one.

``python -m cosim.live.process`` is what runs there. It is told what to serve in its argument, says
the address on its standard output, and ends when its standard input does. A study's server reads
there what it has to ask, a line of JSON each, and writes the answers.
"""

from __future__ import annotations

import asyncio
import json
import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from cosim.base.errors import InputError, RunError

if TYPE_CHECKING:
    from cosim.live.knobs.page_knob import PageKnob
    from cosim.live.server import LiveServer

GONE = "The server of the page is gone."
NICENESS = 5
"""A loop on the same processor goes first, and so does everything else; a hand does not wait."""


class ServerProcess:
    """Starts the server, knows its address, and ends it; a context manager.

    ``wanted`` is the run, as :func:`cosim.realtime.watcher.find_feed` takes it. ``mailboxes`` (by
    user) are the shared memory of users whom pages may move, ``panels`` (by station) and
    ``control`` that of ``cohaptic play``, ``knobs`` what its pages may turn, ``theory`` what is
    known of them; ``foxglove`` lets viewers in that speak Foxglove's protocol. ``study`` is the
    title of a study that asks on the page.
    """

    def __init__(
        self,
        listen: tuple[str, int],
        wanted: str | None,
        *,
        mailboxes: Mapping[str, Path] | None = None,
        control: Path | None = None,
        panels: Mapping[str, Path] | None = None,
        knobs: Sequence[PageKnob] = (),
        theory: Mapping[str, Any] | None = None,
        foxglove: bool = False,
        study: str | None = None,
    ) -> None:
        told = {
            "host": listen[0],
            "port": listen[1],
            "wanted": wanted,
            "mailboxes": {user: str(path) for user, path in (mailboxes or {}).items()},
            "control": None if control is None else str(control),
            "panels": {station: str(path) for station, path in (panels or {}).items()},
            "knobs": [asdict(knob) for knob in knobs],
            "theory": theory,
            "foxglove": foxglove,
            "study": study,
        }
        self.foxglove_address = ""
        """What Foxglove connects to, once ``address`` is known and it is let in."""
        self._process = subprocess.Popen(
            [sys.executable, "-m", "cosim.live.process", json.dumps(told)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,
        )

    def address(self) -> str:
        """What to open in a browser; waits until it is served.

        Raises:
            InputError: it cannot be.
        """
        assert self._process.stdout is not None, "its output is a pipe"
        line = self._process.stdout.readline().decode().strip()
        said: dict[str, str] = json.loads(line) if line else {"error": "the live page died"}
        if "error" in said:
            raise InputError(said["error"])
        self.foxglove_address = said["foxglove"]
        return said["address"]

    def tell(self, message: Mapping[str, Any]) -> None:
        """Give it one message.

        Raises:
            RunError: it is gone.
        """
        assert self._process.stdin is not None, "its input is a pipe"
        try:
            self._process.stdin.write(json.dumps(message).encode() + b"\n")
            self._process.stdin.flush()
        except BrokenPipeError:
            raise RunError(GONE) from None

    def hear(self) -> dict[str, Any]:
        """Its next message; waits for it.

        Raises:
            RunError: it is gone.
        """
        assert self._process.stdout is not None, "its output is a pipe"
        line = self._process.stdout.readline()
        if not line.endswith(b"\n"):
            raise RunError(GONE)
        return json.loads(line)

    def close(self) -> None:
        """End it."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                # What was not taken any more is no fault of who ends it.
                with suppress(BrokenPipeError):
                    pipe.close()
        self._process.terminate()
        self._process.wait()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def main(told: Mapping[str, Any]) -> None:
    """Serve until standard input ends."""
    from cosim.live.control import PlayControl
    from cosim.live.knobs.page_knob import knob_of
    from cosim.live.knobs.panels import Panels
    from cosim.live.mailbox import Mailbox
    from cosim.live.seats import Seats
    from cosim.live.server import LiveServer, Serving
    from cosim.live.study.sheets import Sheets
    from cosim.realtime.ring import Ring

    seats = None
    if not told["mailboxes"]:
        with suppress(OSError):
            os.nice(NICENESS)
    else:
        boxes = {user: Mailbox.attach(Path(path)) for user, path in told["mailboxes"].items()}
        rings = {station: Ring(Path(path)) for station, path in told["panels"].items()}
        knobs = [knob_of(knob) for knob in told["knobs"]]
        asked = told["control"]
        control = None if asked is None else PlayControl.attach(Path(asked))
        seats = Seats(boxes, control, Panels(knobs, rings), told["theory"])
    settings = Serving(
        host=told["host"],
        port=told["port"],
        wanted=told["wanted"],
        play=seats is not None,
        foxglove=told["foxglove"],
    )
    sheets = None if told["study"] is None else Sheets(told["study"], _say)
    asyncio.run(_serve(LiveServer(settings, seats, sheets)))


async def _serve(server: LiveServer) -> None:
    over = asyncio.Event()
    loop = asyncio.get_running_loop()

    unfinished = b""

    def heard() -> None:
        nonlocal unfinished
        read = os.read(0, 65536)
        if not read:
            loop.remove_reader(0)
            over.set()
        *lines, unfinished = (unfinished + read).split(b"\n")
        for line in lines:
            server.show(json.loads(line))

    loop.add_reader(0, heard)

    def ready(address: str) -> None:
        _say({"address": address, "foxglove": server.foxglove_address})

    try:
        await server.serve(ready, over)
    except InputError as error:
        _say({"error": str(error)})


def _say(message: Mapping[str, Any]) -> None:
    sys.stdout.write(json.dumps(message) + "\n")
    sys.stdout.flush()


if __name__ == "__main__":
    main(json.loads(sys.argv[1]))
