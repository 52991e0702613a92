"""All viewers that speak Foxglove's protocol: told together what run there is, and what is new."""

from __future__ import annotations

import asyncio
from contextlib import suppress

from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed

from cosim.live.followed import Followed
from cosim.live.foxglove.client import FoxgloveClient


class FoxgloveClients:
    """Those that are connected."""

    def __init__(self) -> None:
        self._clients: set[FoxgloveClient] = set()
        self._run: Followed | None = None

    def __len__(self) -> int:
        return len(self._clients)

    def show(self, run: Followed | None) -> None:
        """From now on this run, or none."""
        self._run = run
        for client in self._clients:
            client.show(run)

    def offer(self) -> None:
        """There is something new in the run."""
        for client in self._clients:
            client.offer()

    async def serve(self, socket: ServerConnection) -> None:
        """Serve one for as long as it is connected."""
        client = FoxgloveClient(socket)
        client.show(self._run)
        self._clients.add(client)
        sender = asyncio.create_task(client.send())
        try:
            async for text in socket:
                client.hear(text)
        except ConnectionClosed:
            pass
        finally:
            self._clients.discard(client)
            sender.cancel()
            with suppress(ConnectionClosed, asyncio.CancelledError):
                await sender
