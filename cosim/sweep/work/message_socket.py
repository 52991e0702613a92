"""Whole messages over a socket between two processes, as many at a time as are there."""

from __future__ import annotations

import socket
import struct

_LENGTH = struct.Struct("<I")
_ROOM = 1 << 16
"""Bytes that are read at a time."""


class MessageSocket:
    """One end; a message is its length and its bytes."""

    def __init__(self, end: socket.socket) -> None:
        """``end`` belongs to the pipe from now on."""
        self._end = end
        self._read = bytearray()

    def fileno(self) -> int:
        """Of the socket, for those that wait for several."""
        return self._end.fileno()

    def send(self, message: bytes) -> None:
        """Send a message.

        Raises:
            OSError: nobody is there.
        """
        self._end.sendall(_LENGTH.pack(len(message)) + message)

    def receive(self) -> list[bytes]:
        """Wait for something, and return all messages that are whole by then: maybe none.

        Raises:
            EOFError: the other end is closed, and what came before it has been returned.
            OSError: the other end was torn off.
        """
        came = self._end.recv(_ROOM)
        if not came:
            raise EOFError
        self._read += came
        found: list[bytes] = []
        begin = 0
        while begin + _LENGTH.size <= len(self._read):
            first = begin + _LENGTH.size
            (length,) = _LENGTH.unpack_from(self._read, begin)
            if first + length > len(self._read):
                break
            found.append(bytes(self._read[first : first + length]))
            begin = first + length
        del self._read[:begin]
        return found

    def close(self) -> None:
        """Close this end."""
        self._end.close()
