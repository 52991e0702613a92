"""One viewer that speaks Foxglove's protocol: what it wants, and what it is sent next.

It acknowledges nothing of itself, so a ping follows every batch, and the next one is made when its
answer is in: what a slow viewer is sent is what holds then, not what has queued up.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Iterator

from websockets.asyncio.server import ServerConnection

from cosim.base.foxglove.entities import RATE, SceneUpdates
from cosim.live.followed import Followed
from cosim.live.foxglove.channels import Offer
from cosim.live.foxglove.protocol import (
    INFO,
    WARNING,
    advertise,
    clock,
    heard,
    message,
    server_info,
    status,
    unadvertise,
)

NAME = "cohaptic"


class FoxgloveClient:
    """Says what there is, and sends what was asked for, ``RATE`` times a second."""

    def __init__(self, socket: ServerConnection) -> None:
        self._socket = socket
        self._offer: Offer | None = None
        self._updates: SceneUpdates | None = None
        self._subscriptions: dict[int, int] = {}
        """Channel by subscription."""
        self._seen: dict[int, int] = {}
        self._texts: list[str] = []
        self._wake = asyncio.Event()
        self._due = 0.0
        self._tell(server_info(NAME, str(time.time_ns())))

    def show(self, run: Followed | None) -> None:
        """From now on this run, or none; what was offered before is gone."""
        if self._offer is not None:
            self._tell(unadvertise([channel.number for channel in self._offer.channels]))
        self._subscriptions.clear()
        self._seen.clear()
        self._offer = None if run is None else Offer(run)
        if self._offer is None:
            self._tell(advertise(()))
            self._tell(status(INFO, "No run goes on; the next one is shown."))
        else:
            self._updates = self._offer.updates()
            self._tell(advertise(self._offer.channels))

    def hear(self, text: str | bytes) -> None:
        """What it subscribes to, or no longer; the rest of the protocol is not offered."""
        wishes = heard(text)
        known = {channel.number for channel in self._offer.channels} if self._offer else set[int]()
        for subscription, channel in wishes.subscribe:
            if channel not in known:
                self._tell(status(WARNING, f"There is no channel {channel}."))
            elif subscription in self._subscriptions:
                self._tell(status(WARNING, f"Subscription {subscription} is there already."))
            else:
                self._subscriptions[subscription] = channel
        for subscription in wishes.unsubscribe:
            self._subscriptions.pop(subscription, None)

    def offer(self) -> None:
        """There is something new in the run."""
        now = time.monotonic()
        if now >= self._due:
            self._due = max(self._due + 1 / RATE, now + 0.5 / RATE)
            self._wake.set()

    async def send(self) -> None:
        """Send what there is, for as long as it is connected."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            texts, self._texts = self._texts, []
            for text in texts:
                await self._socket.send(text)
            batch = list(self._batch())
            if batch:
                for content in batch:
                    await self._socket.send(content)
                await (await self._socket.ping())

    def _batch(self) -> Iterator[bytes]:
        offer, updates = self._offer, self._updates
        if offer is None or updates is None:
            return
        subscribed = {channel: each for each, channel in self._subscriptions.items()}
        rows = list(offer.rows({*subscribed}, self._seen))
        said = [*rows, *offer.scene(updates)]
        yield clock(offer.now)
        for channel, nanoseconds, content in said:
            if channel in subscribed:
                yield message(subscribed[channel], nanoseconds, content)

    def _tell(self, text: str) -> None:
        self._texts.append(text)
        self._wake.set()
