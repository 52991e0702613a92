"""python-can's ``slcan`` interface with a reader that a damaged line cannot stop.

The package's own reader takes what a line lacks or has too much as it comes, and never gets past a
byte that is no text; its writer waits after each line until an adapter has taken it, which may be
a millisecond over USB. Opening, bit rates and the text of a frame stay as they are there.
"""

from __future__ import annotations

import os
import select
import time
from collections import deque
from typing import Any

from can import CanOperationError, Message
from can.interfaces.slcan import slcanBus

from hil.wire.slcan_lines import LineSplitter

MOST_BYTES = 4096
"""Read at once: what a terminal of the kernel's holds."""


class StrictSlcanBus(slcanBus):
    """Whole, well-formed classic data frames only; reading never waits longer than it is told.

    A line out and all lines in take one system call each, besides a look at what is there.
    """

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
        port: Any = self.serialPortOrig
        descriptor: int = port.fileno()
        while not self._frames:
            left = None if end is None else max(0.0, end - time.monotonic())
            if not select.select([descriptor], [], [], left)[0]:
                return None, False
            text = os.read(descriptor, MOST_BYTES)
            if not text:
                raise CanOperationError("the other end was closed")
            self._frames += self._splitter.feed(text)
        identifier, data = self._frames.popleft()
        message = Message(
            arbitration_id=identifier, data=data, is_extended_id=False, timestamp=time.time()
        )
        return message, False

    def _write(self, string: str) -> None:
        """A line goes out whole or not at all (python-can's hook for writing)."""
        line, port = string.encode("ascii") + self.LINE_TERMINATOR, self.serialPortOrig
        try:
            written = os.write(port.fileno(), line)
        except BlockingIOError:
            written = 0
        if written != len(line):
            raise CanOperationError("its adapter takes no more")
