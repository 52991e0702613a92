"""Nobody's emulator runs on: it ends with the process that started it, however that one ends."""

from __future__ import annotations

import os
import select
import signal
import socket
import subprocess
import sys
from contextlib import suppress

import pytest

OWNER = """
import sys, time
from hil.emulation.launch import Emulator, Order
if __name__ == "__main__":
    emulator = Emulator(Order(name="haply", lockstep=True))
    print(emulator.control.path, flush=True)
    time.sleep(600)
"""


@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGTERM])
def test_it_ends_with_its_owner(how: signal.Signals, tmp_path):
    script = tmp_path / "owner.py"
    script.write_text(OWNER)
    with (
        subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as owner,
        socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as line,
    ):
        assert owner.stdout is not None
        line.connect(owner.stdout.readline().strip())
        os.kill(owner.pid, how)
        owner.wait()
        ready, _, _ = select.select([line], [], [], 30)
        assert ready, "the emulator is still there"
        with suppress(ConnectionResetError):
            assert line.recv(100) == b""
