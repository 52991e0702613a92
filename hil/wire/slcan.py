"""python-can's ``slcan`` interface with a reader that a damaged line cannot stop.

The package's own reader takes what a line lacks or has too much as it comes, and never gets past a
byte that is no text. Opening, bit rates and sending stay as they are there.
"""

from __future__ import annotations

import select
import time
from collections import deque
from typing import Any

from can import Message
from can.interfaces.slcan import slcanBus

from hil.wire.slcan_lines import LineSplitter


class StrictSlcanBus(slcanBus):
    """Whole, well-formed classic data frames only; reading never waits longer than it is told."""

    def __init__(self, channel: str, **options: Any) -> None:
        self._splitter = LineSplitter()
        self._frames: deque[tuple[int, bytes]] = deque()
        super().__init__(channel, timeout=0.0, **options)

    @property
    def damaged(self) -> int:
        """Lines that were left out."""
        return self._splitter.damaged

    def _recv_internal(self, timeout: float | None) -> tuple[Message | None, bool]:
        """The next frame, or ``None`` once the time is over (python-can's hook for reading)."""
        end = None if timeout is None else time.monotonic() + timeout
        while not self._frames:
            port: Any = self.serialPortOrig
            self._frames += self._splitter.feed(port.read(max(1, port.in_waiting)))
            left = None if end is None else end - time.monotonic()
            if self._frames or (left is not None and left <= 0):
                break
            select.select([port.fileno()], [], [], left)
        if not self._frames:
            return None, False
        identifier, data = self._frames.popleft()
        message = Message(
            arbitration_id=identifier, data=data, is_extended_id=False, timestamp=time.time()
        )
        return message, False
