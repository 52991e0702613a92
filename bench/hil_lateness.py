"""How late the paced loop is, side by side with cyclictest in the same seconds on the same machine.

Run as a user who may use SCHED_FIFO: ``uv run python bench/hil_lateness.py [seconds]``. The run is
void where the host took time away from the machine (steal in /proc/stat).
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

from cosim.master.deadlines import Deadlines
from cosim.master.pacing import DeadlinePacer
from hil.realtime import clock_nanosleep, prepare_loop

TICK = Fraction(1, 1024)


def steal() -> int:
    return int(Path("/proc/stat").read_text().splitlines()[0].split()[8])


def cyclictest(seconds: int) -> subprocess.Popen[str] | None:
    program = shutil.which("cyclictest")
    if program is None:
        return None
    interval = round(1e6 * float(TICK))
    command = [program, "-q", "-m", "-t1", "-p70", f"-i{interval}", f"-D{seconds}", "-h20000"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def percentiles(text: str) -> dict[str, float]:
    rows = [(int(m[1]), int(m[2])) for m in re.finditer(r"^(\d{6}) (\d+)", text, re.M)]
    total, found = sum(count for _, count in rows), {}
    for name, share in (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999)):
        seen = 0
        for micro, count in rows:
            seen += count
            if seen >= share * total:
                found[name] = float(micro)
                break
    return found


def main() -> None:
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    before, other = steal(), cyclictest(seconds)
    for grant in prepare_loop():
        print(grant.sentence)
    deadlines = Deadlines()
    pacer = DeadlinePacer(tick_seconds=TICK, deadlines=deadlines, sleep=clock_nanosleep())
    pacer.start(0)
    for tick in range(1, 1024 * seconds):
        pacer.wait(tick)
    theirs = percentiles(other.communicate()[0]) if other is not None else {}
    for name, share in (("p50", 0.5), ("p99", 0.99), ("p99.9", 0.999)):
        ours = deadlines.percentile(share) * 1e6
        ratio = f"{ours / theirs[name]:.2f}" if theirs.get(name) else "-"
        print(f"{name:6} loop {ours:7.0f} us   cyclictest {theirs.get(name, 0):7.0f} us   {ratio}")
    print(f"worst {deadlines.worst / 1000:.0f} us, steal {steal() - before} jiffies")


if __name__ == "__main__":
    main()
