"""Two motors in a process of their own: ``python -m tests.support.hil.motors haply``.

It prints the port to open; ``now`` on its standard input makes it print its torques, ``dump`` every
torque that it was told with its time (CLOCK_MONOTONIC), when it answered that it is at zero, and
how long it was away from its work itself: the probe beside what it measures.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import sys
import time
import tty

from tests.support.hil.motors.boards import BOARDS
from tests.support.hil.motors.told import Motors

TICK = 1 / 1024


def main() -> None:
    """Answer until standard input is closed."""
    motors: Motors = BOARDS[sys.argv[1]]()
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(60))
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    print(os.ttyname(slave), flush=True)
    seen: list[tuple[float, ...]] = []
    zeros: list[float] = []
    away: list[tuple[float, float]] = []
    last = due = time.monotonic()
    while True:
        ready, _, _ = select.select([master, 0], [], [], max(0.0, due - time.monotonic()))
        now = time.monotonic()
        if now - last > 4 * TICK:
            away.append((now, now - last))
        last = now
        told = motors.feed(os.read(master, 65536)) if master in ready else []
        if now >= due:
            told += motors.tick()
            due = max(due + TICK, now - TICK)
        for each in told:
            if each.torques is not None:
                seen.append((now, *each.torques))
            if each.zero:
                zeros.append(now)
            if each.answer:
                with contextlib.suppress(BlockingIOError):
                    os.write(master, each.answer)
        if 0 in ready:
            word = os.read(0, 100)
            if not word:
                return
            # A long answer would keep the motors from looking: it is for the end.
            now = seen[-1][1:] if seen else (0.0, 0.0)
            dump = {"seen": seen, "zeros": zeros, "away": away}
            print(json.dumps(dump if word == b"dump\n" else now), flush=True)


if __name__ == "__main__":
    main()
