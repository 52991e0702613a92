"""The side channel of an emulator: a Unix socket on which tests and proofs talk to it.

It never carries what the device's own protocol carries. One request, one answer, as JSON; and the
lock-step message: "so many bytes (or frames) have gone out", answered once they are all dealt with.
"""

from __future__ import annotations

import json
import socket
import struct
from pathlib import Path
from typing import Any

from hil.device.errors import DeviceGone

SYNC = b"s"
PATIENCE = 60.0
"""Seconds after which an emulator that does not answer is given up."""


class Control:
    """The host's end of an emulator's side channel."""

    def __init__(self, path: str | Path) -> None:
        self.path = path
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._socket.settimeout(PATIENCE)
        try:
            self._socket.connect(str(path))
        except OSError as error:
            self._socket.close()
            raise DeviceGone(f"no emulator answers at {path}: {error.strerror}") from error

    def ask(self, do: str, **values: Any) -> dict[str, Any]:
        """One request and its answer.

        Raises:
            DeviceGone: the emulator is not there any more, or refused.
        """
        answer: dict[str, Any] = json.loads(
            self._exchange(json.dumps({"do": do, **values}).encode())
        )
        if "error" in answer:
            raise DeviceGone(f"the emulator refused '{do}': {answer['error']}")
        return answer

    def sync(self, sent: int) -> int:
        """Wait until the emulator has dealt with ``sent`` bytes (or frames) since it started.

        Returns how many it has sent itself until then: a pseudo-terminal may still be handing
        them over.
        """
        (answered,) = struct.unpack("<q", self._exchange(SYNC + struct.pack("<q", sent)))
        return int(answered)

    def close(self) -> None:
        """Hang up."""
        self._socket.close()

    def _exchange(self, message: bytes) -> bytes:
        try:
            self._socket.send(message)
            answer = self._socket.recv(65536)
        except OSError as error:
            raise DeviceGone(f"the emulator is gone: {error}") from error
        if not answer:
            raise DeviceGone("the emulator is gone")
        return answer
