"""Bytes of a fuzzer as decisions: what to send, and how to spoil it on the way."""

from __future__ import annotations


class Script:
    """Reads decisions off some bytes; past their end every decision is 0."""

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._place = 0

    @property
    def left(self) -> int:
        """Bytes that have not been read."""
        return max(0, len(self._data) - self._place)

    def number(self, below: int) -> int:
        """A number from 0 to ``below`` - 1."""
        size = 1 if below <= 256 else 2
        return int.from_bytes(self.take(size).ljust(size, b"\0"), "little") % max(below, 1)

    def take(self, count: int) -> bytes:
        """The next bytes, fewer at the end."""
        taken = self._data[self._place : self._place + count]
        self._place += count
        return taken

    def rest(self) -> bytes:
        """Everything that is left."""
        return self.take(self.left)


def spoil(stream: bytes, script: Script, most: int = 4) -> bytes:
    """Flip, lose, insert or repeat up to ``most`` stretches of a stream."""
    spoiled = bytearray(stream)
    for _ in range(script.number(most + 1)):
        place = script.number(max(1, len(spoiled)))
        match script.number(4):
            case 0 if spoiled:
                spoiled[place] ^= 1 << script.number(8)
            case 1:
                del spoiled[place : place + 1 + script.number(24)]
            case 2:
                spoiled[place:place] = script.take(1 + script.number(12))
            case _:
                spoiled[place:place] = spoiled[place : place + 1 + script.number(40)]
    return bytes(spoiled)
