"""The memory that the kernel's process and an isolated FMU's share, and how Python talks over it.

One file without a name: a note of what is being called, the FMU's log, the kernel's ``Exchange``
with room for the references and values of one call. A socket beside it carries what only Python can
call, as pickled frames.
"""

from __future__ import annotations

import ctypes
import mmap
import pickle
import socket
from dataclasses import dataclass
from typing import Any

from cosim.master.fmu.log import Log
from cosim.master.kernel.fmu_structures import ExchangeStruct, IsolationStruct
from cosim.master.kernel.native import function_address

_NOTE_BYTES = 256
_LOG_BYTES = 32768


@dataclass(frozen=True, slots=True)
class Room:
    """What one call may carry."""

    references: int
    values: int
    """8-byte values."""

    @property
    def size(self) -> int:
        """The whole file (bytes)."""
        calls = ctypes.sizeof(ExchangeStruct) + (self.references + 1) // 2 * 8 + self.values * 8
        return _NOTE_BYTES + _LOG_BYTES + calls


class Exchange:
    """One process's view of the shared file ``file``; ``ear`` and ``mouth`` are its pipes' ends."""

    def __init__(self, file: int, room: Room, ear: int, mouth: int, looks: int) -> None:
        self._memory = mmap.mmap(file, room.size)
        self.log = Log(memoryview(self._memory)[_NOTE_BYTES : _NOTE_BYTES + _LOG_BYTES])
        self.struct = ExchangeStruct.from_buffer(self._memory, _NOTE_BYTES + _LOG_BYTES)
        self.struct.most_references, self.struct.most_bytes = room.references, room.values * 8
        runtime = ctypes.CDLL(None)
        self.side = IsolationStruct(
            exchange=ctypes.addressof(self.struct),
            read=function_address(runtime.read),
            write=function_address(runtime.write),
            ear=ear,
            mouth=mouth,
            looks=looks,
        )

    def note(self, call: str) -> None:
        """A function of the FMU is about to be called, not by the kernel."""
        text = call.encode()[: _NOTE_BYTES - 1]
        self._memory[: len(text) + 1] = text + b"\0"

    @property
    def noted(self) -> str:
        """The call that was noted last."""
        return bytes(self._memory[:_NOTE_BYTES]).split(b"\0", 1)[0].decode(errors="replace")


def send(talk: socket.socket, content: Any) -> None:
    """Send a frame.

    Raises:
        OSError: the other side is gone.
    """
    data = pickle.dumps(content)
    talk.sendall(len(data).to_bytes(8, "little") + data)


def receive(talk: socket.socket) -> Any:
    """The next frame of our own other process.

    Raises:
        EOFError, OSError: the other side is gone.
    """
    return pickle.loads(_exactly(talk, int.from_bytes(_exactly(talk, 8), "little")))


def _exactly(talk: socket.socket, count: int) -> bytes:
    parts = bytearray()
    while len(parts) < count:
        part = talk.recv(min(count - len(parts), 1 << 20))
        if not part:
            raise EOFError
        parts += part
    return bytes(parts)
