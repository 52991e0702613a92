"""What a tick costs on a CAN bus of raw frames, waiting for the answers and pipelined.

    uv run python bench/can_tick.py [--seconds 5]

The driver speaks through the product's own port for the kernel's CAN sockets, to motors in another
process; a pair of Unix sockets stands for the interface, so the wire takes no time. Told are the
time of a tick's exchange (receive, then command zero), and the processor's share of it.
"""

from __future__ import annotations

import argparse
import os
import socket
import struct
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from hil.device.device import Device
from hil.setup.address import parse
from hil.setup.device_file import parse as parse_file
from hil.setup.registry import find
from hil.wire import can_bus
from hil.wire.socketcan import SocketCanPort
from tests.support.hil.motor_wire import MotorBus
from tests.support.hil.motors.boards import BOARDS
from tests.support.hil.motors.slcan import Lines, line

TICK = 1 / 1024
NODES = {"canopen": "1", "cia402": "1,2"}
LOOK = 50e-6
"""How often the motors look for frames (s): nobody has to wake them for each."""
FRAME = struct.Struct("=IB3x8s")


class Port(SocketCanPort):
    """The product's port on one end of a pair of sockets, which confirms nothing."""

    tells_sent = False

    def for_set_up(self) -> Any:
        """The package ``canopen`` sets the nodes up through the same port."""
        return MotorBus(self)  # type: ignore[arg-type]


def serve(board: str, end: socket.socket) -> None:
    """Motors at the other end, until it is closed; they look by themselves."""
    motors, lines, last = BOARDS[board](), Lines(), time.monotonic()
    end.setblocking(False)
    while True:
        told = []
        try:
            data = end.recv(FRAME.size)
            if not data:
                os._exit(0)
            name, size, content = FRAME.unpack(data)
            told = motors.feed(line(name, content[:size]))
        except BlockingIOError:
            time.sleep(LOOK)
        except OSError:
            os._exit(0)
        while time.monotonic() - last >= TICK:
            last += TICK
            told += motors.tick()
        try:
            for each in told:
                for name, content in lines.frames(each.answer):
                    end.send(FRAME.pack(name, len(content), content))
        except ConnectionError:
            os._exit(0)


def measured(
    board: str, seconds: float, *, pipelined: bool
) -> tuple[np.ndarray, np.ndarray, float]:
    """Times of each tick's exchange (us), the processor's of them, and lost samples (share)."""
    ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    child = os.fork()
    if child == 0:
        ours.close()
        serve(board, theirs)
    theirs.close()
    can_bus._port = lambda _: Port("can0", ours)  # type: ignore[attr-defined]
    url = f"{board}+socketcan://can0?nodes={NODES[board]}&pipelined={int(pipelined)}"
    file = parse_file({"driver": board, "home": [2.2873, 0.8543]})
    device = Device(find(board), parse(url), file)
    device.configure()
    device.home()
    ticks = round(seconds / TICK)
    wall, cpu = np.zeros(ticks), np.zeros(ticks)
    lost, due = 0, time.monotonic()
    for tick in range(ticks):
        due += TICK
        time.sleep(max(0.0, due - time.monotonic()))
        begin, work = time.perf_counter_ns(), time.thread_time_ns()
        lost += device.driver.receive().sample is None
        device.driver.send_zero()
        wall[tick], cpu[tick] = time.perf_counter_ns() - begin, time.thread_time_ns() - work
    device.close()
    os.waitpid(child, 0)
    return wall * 1e-3, cpu * 1e-3, lost / ticks


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=5.0)
    options = parser.parse_args()
    print("| device | exchange, p50 | p99 | of the processor, p50 | without a new sample |")
    print("|---|---|---|---|---|")
    for board in NODES:
        for pipelined in (False, True):
            wall, cpu, lost = measured(board, options.seconds, pipelined=pipelined)
            name = f"`{board}`{', pipelined' if pipelined else ''}"
            middle, high = np.percentile(wall, [50, 99])
            share = np.median(cpu)
            print(f"| {name} | {middle:.0f} us | {high:.0f} us | {share:.0f} us | {lost:.2%} |")


if __name__ == "__main__":
    main()
