"""CAN frames as lines of text (slcan, the LAWICEL protocol): ``tIIILDD..`` and a carriage return.

The text has no checksum of its own (CAN's ends at the adapter, USB's covers the cable). So a line
counts only where its length is exactly what its length digit says: what was cut, lengthened or run
together is left out, and the next line is read again. A digit that turned into another one is
beyond what this protocol can show.
Source: LAWICEL CAN232 manual, "t" and "r" commands.
"""

from __future__ import annotations

import re

_DATA = re.compile(rb"t([0-7][0-9A-Fa-f]{2})([0-8])((?:[0-9A-Fa-f]{2}){0,8})")
LONGEST_LINE = 64
"""More characters than this without a carriage return are noise."""


def data_frame(line: bytes) -> tuple[int, bytes] | None:
    """Identifier and data of a classic frame's line; ``None`` for everything else."""
    found = _DATA.fullmatch(line)
    if found is None or len(found[3]) != 2 * int(found[2]):
        return None
    return int(found[1], 16), bytes.fromhex(found[3].decode("ascii"))


class LineSplitter:
    """Frames out of a stream of characters; what is damaged is counted and left out."""

    def __init__(self) -> None:
        self._pending = b""
        self.damaged = 0

    def feed(self, text: bytes) -> list[tuple[int, bytes]]:
        """The frames whose lines end in ``text``.

        A bell ends a line too: it is the adapter's answer to a command that it refused.
        """
        *lines, self._pending = (self._pending + text).replace(b"\a", b"\r").split(b"\r")
        if len(self._pending) > LONGEST_LINE:
            self._pending, self.damaged = self._pending[-LONGEST_LINE:], self.damaged + 1
        found: list[tuple[int, bytes]] = []
        for line in lines:
            frame = data_frame(line)
            if frame is not None:
                found.append(frame)
            else:
                self.damaged += line[:1] == b"t"
        return found
