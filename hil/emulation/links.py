"""What connects an emulated board with its host: a pseudo-terminal, or a CAN bus."""

from __future__ import annotations

import contextlib
import os
import tty
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

from hil.emulation.board import BoardFrame, Unit

LARGEST_IDENTIFIER, LONGEST_DATA = 0x7FF, 8
"""Of a classic CAN frame with an 11-bit identifier."""


class HostLink(ABC):
    """One end of a wire; bytes, or frames on a bus, are counted both ways."""

    def __init__(self) -> None:
        self.received: int = 0
        self.written: int = 0

    @abstractmethod
    def fileno(self) -> int:
        """What to wait on."""

    @abstractmethod
    def read(self) -> list[Unit]:
        """What has come."""

    @abstractmethod
    def write(self, unit: Unit) -> None:
        """Send an answer."""

    @abstractmethod
    def close(self) -> None:
        """Pull the cable."""


class PtyLink(HostLink):
    """A pseudo-terminal: the host opens ``path`` as if it were a serial device."""

    def __init__(self) -> None:
        super().__init__()
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.path = os.ttyname(self._slave)

    def fileno(self) -> int:
        """The master's descriptor."""
        return self._master

    def read(self) -> list[Unit]:
        """The bytes that have come, as one chunk."""
        data = self._bytes()
        self.received += len(data)
        return [data] if data else []

    def _bytes(self) -> bytes:
        try:
            return os.read(self._master, 65536)
        except OSError:
            return b""

    def write(self, unit: Unit) -> None:
        """Send bytes; a host that never reads loses them, as on a real line."""
        assert isinstance(unit, bytes)
        self.written += self._put(unit)

    def _put(self, data: bytes) -> int:
        try:
            return os.write(self._master, data)
        except BlockingIOError:
            return 0

    def close(self) -> None:
        """The host's next read or write fails."""
        for end in (self._slave, self._master):
            with contextlib.suppress(OSError):
                os.close(end)


class SlcanLink(PtyLink):
    """CAN frames as slcan text (LAWICEL) on a pseudo-terminal."""

    def __init__(self) -> None:
        super().__init__()
        self._text = b""
        self._open = False
        self._rest = b""
        """Of a line that found the host's buffer full: an adapter loses whole frames only."""

    def read(self) -> list[Unit]:
        """The frames that have come; of the adapter's commands it knows open and close."""
        frames: list[Unit] = []
        *lines, self._text = (self._text + self._bytes()).split(b"\r")
        for line in lines:
            if line in {b"O", b"C"}:
                self._open = line == b"O"
            frame = parse_slcan(line)
            if frame is not None:
                frames.append(frame)
        self.received += len(frames)
        return frames

    def write(self, unit: Unit) -> None:
        """Send one frame as a line; a channel that nobody has opened stays silent."""
        assert isinstance(unit, BoardFrame)
        if not self._open:
            return
        self._rest = self._rest[self._put(self._rest) :] if self._rest else b""
        if self._rest:
            return
        line = f"t{unit.identifier:03X}{len(unit.data)}{unit.data.hex()}\r".encode()
        done = self._put(line)
        self._rest = line[done:] if done else b""
        self.written += done > 0


def parse_slcan(line: bytes) -> BoardFrame | None:
    """A standard data (``t``) or remote (``r``) frame of a line; ``None`` for anything else.

    Strict as a real adapter is: what was read has to give the very line again.
    """
    kind, rest = line[:1], line[5:]
    try:
        identifier, size = int(line[1:4], 16), int(line[4:5])
        data = bytes.fromhex(rest.decode("ascii"))
    except ValueError:
        return None
    again = b"%c%03x%d%s" % (kind or b"?", identifier, size, data.hex().encode())
    if again != kind + line[1:].lower() or identifier > LARGEST_IDENTIFIER or size > LONGEST_DATA:
        return None
    if kind == b"t" and size == len(data):
        return BoardFrame(identifier, data)
    return BoardFrame(identifier, remote=True) if kind == b"r" and not data else None


class CanLink(HostLink):
    """Any python-can bus; with ``udp_multicast`` its own frames come back and are left out."""

    def __init__(self, own: Callable[[int], bool], **options: Any) -> None:
        import can

        super().__init__()
        self._can: Any = can
        self._own = own
        self._bus: Any = can.Bus(**options)

    def fileno(self) -> int:
        """The bus's descriptor."""
        return int(self._bus.fileno())

    def read(self) -> list[Unit]:
        """The frames that have come from others."""
        frames: list[Unit] = []
        while True:
            message = self._bus.recv(0)
            if message is None:
                return frames
            if self._own(message.arbitration_id) and not message.is_remote_frame:
                continue
            self.received += 1
            frames.append(
                BoardFrame(message.arbitration_id, bytes(message.data), message.is_remote_frame)
            )

    def write(self, unit: Unit) -> None:
        """Send one frame."""
        assert isinstance(unit, BoardFrame)
        self.written += 1
        self._bus.send(
            self._can.Message(arbitration_id=unit.identifier, data=unit.data, is_extended_id=False)
        )

    def close(self) -> None:
        """Leave the bus."""
        self._bus.shutdown()
