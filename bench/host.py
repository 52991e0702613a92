"""What the machine itself does to deadlines, measured beside a loop: cyclictest, steal, load."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

SHARES = {"p50": 0.5, "p99": 0.99, "p99.9": 0.999}
VOID_STEAL = 0.02
"""Share of the processors' time stolen by the host above which a measurement says nothing."""


class Host:
    """cyclictest at the loop's rate in the same seconds, and what the host took from the machine.

    A measurement on a machine whose processors were stolen for more than ``VOID_STEAL`` of the
    time is void.
    """

    def __init__(
        self, seconds: float, *, priority: int = 80, threads: int = 1, interval: int = 976
    ) -> None:
        self.seconds = seconds
        self._steal, self._load = _steal(), os.getloadavg()[0]
        program = shutil.which("cyclictest")
        self._process = program and subprocess.Popen(
            [
                *(program, "-q", "-m", f"-t{threads}", "-a", f"-p{priority}", f"-i{interval}"),
                *("-d0", f"-D{round(seconds)}", "-h30000"),
            ],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def close(self) -> dict[str, float]:
        """Lateness of cyclictest's threads in us (p50, p99, p99.9, worst, misses), steal, load."""
        found: dict[str, float] = {}
        if self._process:
            found |= _percentiles(self._process.communicate()[0])
        stolen = (_steal() - self._steal) / os.sysconf("SC_CLK_TCK")
        found["steal"] = stolen / (self.seconds * (os.cpu_count() or 1))
        found["load"] = max(self._load, os.getloadavg()[0])
        return found


def verdict(found: dict[str, float]) -> str:
    """A sentence about how far the measurement can be believed."""
    stolen = f"steal {found['steal']:.1%}, load {found['load']:.1f}"
    if found["steal"] > VOID_STEAL:
        return f"VOID: the host was busy ({stolen})"
    return f"valid ({stolen})"


def machine() -> str:
    """What this is measured on, in a sentence."""
    named = re.search(r"model name\s*: (.+)", Path("/proc/cpuinfo").read_text())
    name = named[1] if named else os.uname().machine
    return f"{os.cpu_count()} x {name}, Linux {os.uname().release}"


def ratios(name: str, ours: dict[str, float], host: dict[str, float]) -> str:
    """A row of the table of ratios: lateness in us beside cyclictest's, with their ratio."""
    cells = [name]
    for share in (*SHARES, "worst"):
        micro, theirs = ours[share] * 1e6, host.get(share)
        ratio = f"{micro / theirs:.2f}" if theirs else "–"
        known = f"{theirs:.0f}" if theirs else "–"
        cells.append(f"**{ratio}** ({micro:.0f} / {known})")
    return "| " + " | ".join([*cells, verdict(host)]) + " |"


def compare(name: str, ours: dict[str, float], host: dict[str, float]) -> None:
    """Print lateness in us beside cyclictest's; ``ours`` is a deadline summary (s)."""
    for share in SHARES:
        micro, theirs = ours[share] * 1e6, host.get(share)
        ratio = f"{micro / theirs:8.2f}" if theirs else "       -"
        known = f"{theirs:8.0f}" if theirs is not None else "       -"
        print(f"  {name:28} {share:6} {micro:8.0f} us   cyclictest {known} us   ratio {ratio}")


def _steal() -> int:
    return int(Path("/proc/stat").read_text().splitlines()[0].split()[8])


def _percentiles(text: str) -> dict[str, float]:
    counts: dict[int, int] = {}
    for line in text.splitlines():
        if re.match(r"\d{6}\s", line):
            micro, *threads = line.split()
            counts[int(micro)] = sum(int(count) for count in threads)
    total = sum(counts.values())
    worst = re.search(r"# Max Latencies: ([\d ]+)", text)
    if not total:
        return {}
    found = {"worst": float(max(map(int, worst[1].split()))) if worst else 0.0}
    overflow = re.search(r"# Histogram Overflows: ([\d ]+)", text)
    over = sum(map(int, overflow[1].split())) if overflow else 0
    found["misses"] = float(sum(n for micro, n in counts.items() if micro >= 976) + over)
    found["wakes"] = float(total + over)
    for name, share in SHARES.items():
        seen = 0
        for micro in sorted(counts):
            seen += counts[micro]
            if seen >= share * (total + over):
                found[name] = float(micro)
                break
        else:
            found[name] = found["worst"]
    return found
