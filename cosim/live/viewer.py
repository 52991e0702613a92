"""One page that looks on: it is sent the newest frame, and no more than it acknowledges.

A socket takes megabytes before its sender notices that nobody reads. So a page acknowledges every
frame that it has drawn, and never has more than ``CREDIT`` on the way; what it is sent next is what
holds then, not what has queued up.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

CREDIT = 4
"""Frames on the way to one page."""
MOST_SIGNALS = 24
"""Signals that one page may plot."""


@dataclass(slots=True, eq=False)
class Viewer:
    """What one page wants, has had, and has acknowledged."""

    signals: list[str] = field(default_factory=list[str])
    seen: dict[int, int] = field(default_factory=dict[int, int])
    """Rows that it has had, by record group."""
    sent: int = 0
    acknowledged: int = 0
    user: str | None = None
    """Whose hand its pointer moves."""
    news: list[str] = field(default_factory=list[str])
    """Messages that come before the next frame."""
    _wake: asyncio.Event = field(default_factory=asyncio.Event)
    _frame_is_due: bool = False

    @property
    def has_credit(self) -> bool:
        """Whether another frame may be sent."""
        return self.sent - self.acknowledged < CREDIT

    def tell(self, message: dict[str, Any]) -> None:
        """Send this before the next frame."""
        self.news.append(json.dumps(message, separators=(",", ":")))
        self._wake.set()

    def offer(self) -> None:
        """There is a new picture."""
        self._frame_is_due = True
        if self.has_credit:
            self._wake.set()

    def acknowledge(self, number: int) -> None:
        """The page has drawn frame ``number`` and those before it."""
        if self.acknowledged < number <= self.sent:
            self.acknowledged = number
            if self._frame_is_due:
                self._wake.set()

    async def next(self, frame: Callable[[Viewer], str | None]) -> list[str]:
        """Wait until there is something to send, and make it at that moment."""
        await self._wake.wait()
        self._wake.clear()
        found, self.news = self.news, []
        if self._frame_is_due and self.has_credit:
            self._frame_is_due = False
            text = frame(self)
            if text is not None:
                found.append(text)
        return found
