"""The kernel's CAN sockets without a package in between: one system call a frame.

The kernel hands every frame of ours back once it was on the bus (MSG_CONFIRM), so that what only
waits in a queue is known. Error frames come as what they are.
Source: Linux, Documentation/networking/can.rst.
"""

from __future__ import annotations

import errno
import select
import socket
import struct
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

from hil.device.errors import DeviceGone
from hil.wire.can_port import CanFrame, FrameKind

_FRAME = struct.Struct("=IB3x8s")
_EXTENDED, _REMOTE, _ERROR = 0x80000000, 0x40000000, 0x20000000
_IDENTIFIER, _ALL_ERRORS = 0x7FF, 0x1FFFFFFF
_NO_DATA = _EXTENDED | _REMOTE | _ERROR
_ERROR_FILTER, _CONFIRMED = 2, 0x800
"""CAN_RAW_ERR_FILTER and MSG_CONFIRM, which not every Python's socket module has names for."""


class SocketCanPort:
    """An interface of Linux: ``can0``."""

    tells_sent = True

    def __init__(self, channel: str, made: Any = None) -> None:
        """Open it; ``made`` is a socket that is open already.

        Raises:
            DeviceGone: there is no such interface, or it is down.
        """
        self.channel = channel
        try:
            self._socket = made or _opened(channel)
        except OSError as error:
            raise DeviceGone(
                f"the CAN interface {channel} cannot be opened: {error.strerror}"
            ) from error
        self._socket.setblocking(False)

    def send(self, identifier: int, data: bytes, *, remote: bool) -> None:
        """Queue a frame."""
        word = identifier | (_REMOTE if remote else 0)
        try:
            self._socket.send(_FRAME.pack(word, len(data), data))
        except OSError as error:
            if error.errno in {errno.ENOBUFS, errno.EAGAIN}:
                raise DeviceGone(
                    "takes no more frames: its queue is full, because nobody acknowledges them"
                ) from error
            raise DeviceGone(f"does not take a frame: {error.strerror}") from error

    def receive(self, wait: float) -> CanFrame | None:
        """The next frame, ``None`` where none comes within ``wait`` (s)."""
        # Not poll(2), which knows whole milliseconds alone: more than all devices have in a tick.
        if wait > 0.0 and not select.select([self._socket], [], [], wait)[0]:
            return None
        try:
            data, _, flags, _ = self._socket.recvmsg(_FRAME.size)
        except BlockingIOError:
            return None
        except OSError as error:
            raise DeviceGone(f"is gone: {error.strerror}") from error
        if len(data) != _FRAME.size:
            raise DeviceGone("is gone: it brings something that is no frame")
        word, size, content = _FRAME.unpack(data)
        content = content[:size]
        if not (word & _NO_DATA or flags & _CONFIRMED):
            return CanFrame(word & _IDENTIFIER, content)
        if word & _ERROR:
            return CanFrame(word & _ALL_ERRORS, content, FrameKind.ERROR)
        kind = FrameKind.SENT if flags & _CONFIRMED else FrameKind.OTHER
        return CanFrame(word & _IDENTIFIER, content, kind)

    @contextmanager
    def for_set_up(self) -> Generator[Any]:
        """Another socket on the same interface; ours takes no frame meanwhile."""
        import can

        with can.Bus(interface="socketcan", channel=self.channel) as bus:
            yield bus

    def close(self) -> None:
        """Let go of it."""
        self._socket.close()


def _opened(channel: str) -> socket.socket:
    made = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    try:
        made.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_RECV_OWN_MSGS, 1)
        made.setsockopt(socket.SOL_CAN_RAW, _ERROR_FILTER, _ALL_ERRORS)
        made.bind((channel,))
    except OSError:
        made.close()
        raise
    return made
