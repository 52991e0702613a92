"""How late the paced loop is beside cyclictest in the same seconds, and what devices cost a tick.

    uv run python bench/hil_lateness.py [--seconds 20] [--only mock haply]

For no device, the simulated one (mock) and every driver on its emulator: lateness of the 1024 Hz
loop and cyclictest's, side by side, at p50, p99 and p99.9; the time of a tick's read and write; and
the round trip from a written command to its answer, where the protocol answers commands; and at the
end the ratios in one table. Needs a user who may use SCHED_FIFO. A line is void where the host
stole the processors; a loop that fails ends with status 1.
"""

from __future__ import annotations

import argparse
import os
import pickle
import select
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
from host import SHARES, Host, compare, machine, ratios, verdict

sys.path.insert(0, str(Path(__file__).parents[1]))

from cosim.base.system.grants import clock_nanosleep, prepare_loop
from cosim.realtime.pacing import DeadlinePacer
from hil.device.contract import ZERO
from hil.device.device import Device
from tests.support.hil.driver_bench import Bench
from tests.support.hil.hil_bench import Puppet, mock

TICK = Fraction(1, 1024)
EMULATOR_PRIORITY = 65
ARRANGEMENTS = ("no device", "mock", "haply", "cobs", "odrive (slcan)", "odrive", "canopen (slcan)",
                "canopen", "cia402 (slcan)", "cia402",
                "canopen (pipelined)", "cia402 (pipelined)")  # fmt: skip
LONGEST_ANSWER = 500
"""Longest wait for an answer (us); what is later counts as no answer."""


def in_child(work: Callable[[], Any]) -> Any:
    """Run in a process that can become real-time and be thrown away; what it returns."""
    ours, theirs = os.pipe()
    process = os.fork()
    if process == 0:
        os.close(ours)
        with suppress(BaseException), os.fdopen(theirs, "wb") as pipe:
            pickle.dump(work(), pipe)
        os._exit(0)
    os.close(theirs)
    with os.fdopen(ours, "rb") as pipe:
        data = pipe.read()
    os.waitpid(process, 0)
    return pickle.loads(data) if data else None


def loop(device: Device | None, seconds: float) -> dict[str, Any]:
    """A paced loop that exchanges zero torque with a device."""
    if device is not None:
        device.configure()
        device.home()
    ticks = round(seconds / TICK)
    exchanges, answers = np.zeros(ticks), np.full(ticks, np.nan)
    ages = np.zeros(ticks, dtype=np.int64)
    poll = answering(device) if device is not None else None
    prepare_loop()
    pacer = DeadlinePacer(tick_seconds=TICK, sleep=clock_nanosleep())
    rest = device.rest_ticks if device is not None else 0
    pacer.start(-rest)
    clock = time.monotonic_ns
    for tick in range(-rest, ticks):
        pacer.wait(tick)
        if device is None:
            continue
        began = clock()
        ages[tick] = device.read(tick).sample_age
        device.write(tick, ZERO)
        done = clock()
        exchanges[tick] = done - began
        if poll is not None and tick % 16 == 0 and poll.poll(LONGEST_ANSWER * 1e-3):
            answers[tick] = clock() - done
    found: dict[str, Any] = {"deadlines": pacer.deadlines.summary()}
    if device is not None:
        found |= {
            "exchange": np.percentile(exchanges, [50, 99]) * 1e-3,
            "answer": np.nanpercentile(answers, [50, 99]) * 1e-3
            if not np.isnan(answers).all()
            else None,
            "aged": float(np.mean(ages > 0)),
            "state": str(device.state),
        }
        device.close()
    return found


def answering(device: Device) -> select.poll | None:
    """A poll on the port of a device that answers every command."""
    if device.driver.driver not in {"haply", "cobs"}:
        return None
    poll = select.poll()
    poll.register(device.driver._port._descriptor, select.POLLIN)  # type: ignore[attr-defined]
    return poll


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--only", nargs="*", choices=ARRANGEMENTS)
    options = parser.parse_args()
    table: list[str] = []
    failed = False
    for name in options.only or ARRANGEMENTS:
        bench = Bench()
        try:
            device = None
            if name == "mock":
                device = mock(Puppet(), output=False)
            elif name != "no device":
                emulator = bench.emulator(name, lockstep=False, priority=EMULATOR_PRIORITY)
                # A fault of lateness would end the exchange: output stays dry, and no clock.
                device = bench.device(name, emulator, output=False)
            host = Host(options.seconds, threads=2)
            found = in_child(lambda device=device: loop(device, options.seconds))
            seen = host.close()
        finally:
            with suppress(Exception):
                bench.close()
        print(f"{name}: {verdict(seen)}")
        if found is None:
            print("  the loop failed")
            failed = True
            continue
        deadlines = found["deadlines"]
        compare(name, deadlines, seen)
        table.append(ratios(name, deadlines, seen))
        print(
            f"  misses {deadlines['misses']} of {deadlines['ticks']} (cyclictest "
            f"{seen.get('misses', 0):.0f} of {seen.get('wakes', 0):.0f}), worst "
            f"{deadlines['worst'] * 1e3:.1f} ms (cyclictest {seen.get('worst', 0) * 1e-3:.1f} ms)"
        )
        if "exchange" in found:
            middle, high = found["exchange"]
            answer = found["answer"]
            told = f"{answer[0]:.0f} us, p99 {answer[1]:.0f} us" if answer is not None else "-"
            print(
                f"  read and write {middle:.0f} us, p99 {high:.0f} us; answer after {told}; "
                f"ticks without a new sample {found['aged']:.2%}; {found['state']}"
            )
    print(f"\nLateness by cyclictest's in the same seconds (us), on {machine()}:\n")
    print("| device | " + " | ".join((*SHARES, "worst")) + " | host |")
    print("|---" * (len(SHARES) + 3) + "|")
    print("\n".join(table))
    if failed:
        raise SystemExit(1)


if __name__ == "__main__":
    main()
