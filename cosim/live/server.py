"""The server of the live page: one port for page, modules and socket, in a process of its own.

It reads the rings of a run read-only (``cosim.live.followed``) and never talks to the loop. Where
it serves ``cohaptic play``, what pages say of their pointers goes into mailboxes, again shared
memory.
"""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any, cast
from urllib.parse import urlsplit

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from cosim.base.errors import InputError
from cosim.live.access import FOXGLOVE, Access, hosts_of
from cosim.live.followed import Followed
from cosim.live.foxglove.clients import FoxgloveClients
from cosim.live.requests import PageRequests, is_foxglove, subprotocol
from cosim.live.seats import Seats
from cosim.live.study.sheets import LARGEST_ANSWER, Sheets
from cosim.live.viewer import MOST_SIGNALS, Viewer

WATCH_RATE = 32.0
"""Frames a second where nobody touches anything; the display rate of the thesis."""
PLAY_RATE = 120.0
USED_TICKS = 2.0
"""Until a tick has used a pointer's sample, and its row is there."""
LARGEST_MESSAGE = 4096
"""Of a page (bytes)."""
SEARCH_SECONDS = 0.2
"""From one look for a run to the next, while none is shown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Serving:
    """What is served, and to whom."""

    host: str
    port: int
    wanted: str | None = None
    """The run: its folder, scenario or process; ``None`` takes the newest."""
    play: bool = False
    foxglove: bool = False
    """Whether viewers that speak Foxglove's protocol are let in, too."""


class LiveServer:
    """Serves one run at a time to any number of pages."""

    def __init__(
        self, settings: Serving, seats: Seats | None = None, sheets: Sheets | None = None
    ) -> None:
        self._settings = settings
        self._seats = seats
        self._sheets = sheets
        self._requests = PageRequests(foxglove=settings.foxglove)
        self._viewers: set[Viewer] = set()
        self._foxgloves = FoxgloveClients()
        self._run: Followed | None = None
        self._common = ""
        self.access = Access(hosts=frozenset())

    async def serve(self, ready: Callable[[str], None], until: asyncio.Event) -> None:
        """Serve until ``until`` is set; ``ready`` is told the address to open.

        Raises:
            InputError: nobody can listen there.
        """
        given = self._settings
        try:
            server = await serve(
                self._connected,
                given.host,
                given.port,
                process_request=self._request,
                select_subprotocol=subprotocol,
                compression=None,
                max_size=LARGEST_MESSAGE if self._sheets is None else LARGEST_ANSWER,
                max_queue=8,
                open_timeout=5,
                close_timeout=1,
                server_header=None,
            )
        except OSError as error:
            message = (
                f"--live-at: {given.host}:{given.port} cannot be listened on: {error.strerror}"
            )
            raise InputError(message) from None
        async with server:
            self.access = Access(hosts=hosts_of(given.host, _port(server)))
            ready(self.address)
            frames = asyncio.create_task(self._frames())
            await until.wait()
            frames.cancel()
            with suppress(asyncio.CancelledError):
                await frames

    def show(self, sheet: Mapping[str, Any]) -> None:
        """Ask this on every page; of a study's server alone."""
        assert self._sheets is not None, "nobody asks anything here"
        self._sheets.show(sheet)
        self._tell_sheet()

    @property
    def address(self) -> str:
        """What to open, with the token in its fragment."""
        host = min(self.access.hosts, key=lambda name: (name.startswith("localhost"), name))
        return f"http://{host}/#{self.access.token}"

    @property
    def foxglove_address(self) -> str:
        """What Foxglove connects to."""
        page = urlsplit(self.address)
        return f"ws://{page.netloc}{FOXGLOVE}{page.fragment}"

    # --- pages -----------------------------------------------------------------------------------

    def _request(self, connection: ServerConnection, request: Request) -> Response | None:
        del connection
        viewers = len(self._viewers) + len(self._foxgloves)
        return self._requests.answer(request, self.access, viewers)

    async def _connected(self, socket: ServerConnection) -> None:
        if is_foxglove(socket.request):
            await self._foxgloves.serve(socket)
        else:
            await self._serve_page(socket)

    async def _serve_page(self, socket: ServerConnection) -> None:
        viewer = Viewer()
        self._viewers.add(viewer)
        if self._seats is not None:
            self._seats.seat(viewer)
        if self._sheets is not None:
            viewer.tell(self._sheets.told())
        self._introduce(viewer)
        sender = asyncio.create_task(self._send(socket, viewer))
        try:
            async for text in socket:
                self._hear(viewer, text)
        except ConnectionClosed:
            pass
        finally:
            self._viewers.discard(viewer)
            if self._seats is not None:
                self._seats.leave(viewer)
                self._tell_seats()
            sender.cancel()

    async def _send(self, socket: ServerConnection, viewer: Viewer) -> None:
        with suppress(ConnectionClosed, asyncio.CancelledError):
            while True:
                for text in await viewer.next(self._frame):
                    await socket.send(text)

    def _hear(self, viewer: Viewer, text: str | bytes) -> None:
        """What a page says; what is not understood is dropped, for nothing here depends on it."""
        try:
            message: Any = json.loads(text)
        except ValueError:
            return
        if not isinstance(message, dict):
            return
        said = cast("dict[str, Any]", message)
        acknowledged, signals = said.get("ack"), said.get("watch")
        if type(acknowledged) is int:
            viewer.acknowledge(acknowledged)
        if isinstance(signals, list):
            names = [name for name in cast("list[Any]", signals) if isinstance(name, str)]
            viewer.signals = names[:MOST_SIGNALS]
        if self._seats is not None and self._seats.hear(viewer, said):
            self._tell_seats()
        if self._sheets is not None and self._sheets.hear(said):
            self._tell_sheet()

    # --- the run ---------------------------------------------------------------------------------

    async def _frames(self) -> None:
        """Follow a run, and offer its picture to everybody at the page's rate."""
        period = 1.0 / (PLAY_RATE if self._settings.play else WATCH_RATE)
        due = time.monotonic()
        while True:
            if self._run is None:
                self._look()
            elif not self._run.running:
                self._picture()
                self._end()
            elif self._viewers or self._foxgloves:
                self._picture()
            due = max(due + (period if self._run else SEARCH_SECONDS), time.monotonic())
            if await self._rest_until(due):
                due = time.monotonic()

    async def _rest_until(self, due: float) -> bool:
        """Whether a hand was moved meanwhile, and a tick has had the time to use it."""
        if self._seats is None or self._run is None:
            await asyncio.sleep(max(0.0, due - time.monotonic()))
            return False
        with suppress(TimeoutError):
            async with asyncio.timeout_at(due):
                await self._seats.moved.wait()
        if not self._seats.moved.is_set():
            return False
        self._seats.moved.clear()
        await asyncio.sleep(USED_TICKS / self._run.rate)
        return True

    def _look(self) -> None:
        self._run = Followed.find(self._settings.wanted)
        if self._run is not None:
            if self._seats is not None:
                self._seats.follow(self._run.scene)
            for viewer in self._viewers:
                viewer.seen.clear()
                self._introduce(viewer)
            self._foxgloves.show(self._run)

    def _end(self) -> None:
        assert self._run is not None, "a run that ends was shown"
        self._run.close()
        self._run = None
        for viewer in self._viewers:
            viewer.tell({"type": "ended"})
        self._foxgloves.show(None)

    def _introduce(self, viewer: Viewer) -> None:
        """Tell a page what it looks at."""
        run = self._run
        if run is None:
            viewer.tell({"type": "waiting"})
            return
        theory = None if self._seats is None else self._seats.theory
        viewer.tell({"type": "run", **run.told(), "theory": theory})
        if self._seats is not None:
            viewer.tell(self._seats.told(viewer))

    def _tell_seats(self) -> None:
        for viewer in self._viewers:
            if self._seats is not None:
                viewer.tell(self._seats.told(viewer))

    def _tell_sheet(self) -> None:
        for viewer in self._viewers:
            if self._sheets is not None:
                viewer.tell(self._sheets.told())

    def _picture(self) -> None:
        """Read the rings once for everybody."""
        run = self._run
        assert run is not None, "there is a run to draw"
        run.read()
        self._foxgloves.offer()
        status = run.status()
        shown = {
            "clock": round(time.monotonic() * 1e3, 3),
            "time": round(run.time, 6),
            "values": run.newest(),
            "lost": run.lost,
            "status": None if status is None else _finite(asdict(status)),
        }
        if self._seats is not None:
            shown["seen"] = self._seats.seen()
        self._common = json.dumps(shown, separators=(",", ":"), allow_nan=False)[1:-1]
        for viewer in self._viewers:
            viewer.offer()

    def _frame(self, viewer: Viewer) -> str | None:
        """The picture as it is now, with the rows that this page has not had."""
        if self._run is None or not self._common:
            return None
        viewer.sent += 1
        rows = json.dumps(self._run.since(viewer.signals, viewer.seen), separators=(",", ":"))
        return f'{{"type":"frame","number":{viewer.sent},{self._common},"rows":{rows}}}'


def _finite(value: Any) -> Any:
    """What JSON can hold: a number that is none becomes ``None``."""
    if isinstance(value, dict):
        return {key: _finite(each) for key, each in cast("dict[str, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in cast("list[Any]", value)]
    return value if not isinstance(value, float) or value - value == 0.0 else None


def _port(server: Server) -> int:
    return int(next(iter(server.sockets)).getsockname()[1])
