"""Who has a port: one device has it, across processes and users, until its last holder is gone.

A serial port is locked on its own descriptor (flock), which is kept over fork and freed with the
last process that has it, even a killed one. A node on a CAN bus has no descriptor of its own: a
listening abstract socket named by bus and node stands for it, seen by all users and never stale.
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import struct
import sys
from collections.abc import Iterable
from pathlib import Path

from hil.device.errors import DeviceError

if sys.platform != "win32":
    import fcntl
    import termios

_LOCKS = Path("/proc/locks")


def own_port(descriptor: int, name: str) -> None:
    """Lock an open serial port.

    Raises:
        DeviceError: another device has it.
    """
    if sys.platform == "win32":
        return  # the system itself opens a port once only
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise DeviceError(_in_use(name, _holder_of(descriptor))) from None
    except OSError:
        return  # no file that could be locked
    if not os.ttyname(descriptor).startswith("/dev/pts/"):
        # Against programs that lock nothing; on a pseudo-terminal it would outlive its holder.
        with contextlib.suppress(OSError):
            fcntl.ioctl(descriptor, termios.TIOCEXCL)


class OwnedNodes:
    """Nodes on a bus that nobody else may speak to."""

    def __init__(self, bus: str, nodes: Iterable[int]) -> None:
        """Claim them.

        Raises:
            DeviceError: another device has one of them, or the system does not let claim it.
        """
        self._sockets: list[socket.socket] = []
        if sys.platform != "linux":
            return  # there are no abstract sockets
        for node in nodes:
            place, what = f"\0cohaptic-{bus}-{node}", f"node {node} on {bus}"
            try:
                made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
                self._sockets.append(made)
                made.bind(place)
                made.listen(1)
            except OSError as error:
                self.close()
                if error.errno == errno.EADDRINUSE:
                    raise DeviceError(_in_use(what, _listener(place))) from None
                raise DeviceError(f"{what} cannot be claimed: {error.strerror}") from error

    def close(self) -> None:
        """Let go of them."""
        while self._sockets:
            self._sockets.pop().close()


def _in_use(what: str, holder: int | None) -> str:
    if holder == os.getpid():
        return f"{what} is in use by another device of this very run: give each a place of its own"
    who = "another process" if holder is None else f"process {holder}{_name_of(holder)}"
    return f"{what} is in use by {who}: end that first"


def _name_of(process: int) -> str:
    with contextlib.suppress(OSError):
        words = Path(f"/proc/{process}/cmdline").read_bytes().replace(b"\0", b" ").decode().strip()
        return f" ({words[:60]})" if words else ""
    return ""


def _holder_of(descriptor: int) -> int | None:
    """The process that locked the file first, as /proc/locks has it (proc(5))."""
    status = os.fstat(descriptor)
    device = f"{os.major(status.st_dev):02x}:{os.minor(status.st_dev):02x}"
    with contextlib.suppress(OSError, ValueError, IndexError):
        for line in _LOCKS.read_text("ascii").splitlines():
            fields = line.split()
            if fields[1] == "FLOCK" and fields[5] == f"{device}:{status.st_ino}":
                return int(fields[4])
    return None


def _listener(place: str) -> int | None:
    """The process that listens on an abstract socket (unix(7), SO_PEERCRED)."""
    with contextlib.suppress(OSError), socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as asking:
        asking.settimeout(0.2)
        asking.connect(place)
        size = struct.calcsize("3i")
        found = asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, size)
        return int(struct.unpack("3i", found)[0])
    return None
