"""What the time from a process's start to the first tick of a scenario goes into.

    uv run python bench/start_up.py [SCENARIO] [--processes 10]

Each round is a process of its own; compiled bytecode and filled caches are those of the rounds
before it (the first one, which fills them, does not count). The least and the median of each part
are printed in ms; the parts of a round add up to its total. ``processor`` is the processor time of
all of it, which says more where others keep the machine busy.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PARTS = ("interpreter", "imports", "load", "assemble", "start", "record", "first tick")


def measure(scenario: str, since: float) -> dict[str, float]:
    """Seconds of each part, in this process, which began at ``since`` of the monotonic clock."""
    times: dict[str, float] = {}

    def lap(part: str) -> None:
        times[part] = time.monotonic() - since - sum(times.values())

    lap("interpreter")
    from cosim.base.system.garbage import collect_seldom

    collect_seldom()  # as the command does
    from cosim.analysis import load_tuned
    from cosim.master.run.simulation import assemble
    from cosim.record.reader import RUN_FILE
    from cosim.record.writer import Recorder

    lap("imports")
    loaded = load_tuned(scenario)
    lap("load")
    with tempfile.TemporaryDirectory() as folder, assemble(loaded) as simulation:
        lap("assemble")
        simulation.start(recorded=True)
        lap("start")
        with Recorder(Path(folder) / RUN_FILE, loaded.ticks) as recorder:
            recorder.begin(simulation.groups, loaded.base_rate)
            lap("record")
            simulation.advance(1, recorder)
            lap("first tick")
    times["processor"] = time.process_time()
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("scenario", nargs="?", default="two_users_box")
    parser.add_argument("--processes", type=int, default=10)
    parser.add_argument("--since", type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.since is not None:
        print(json.dumps(measure(options.scenario, options.since)))
        return
    rounds: list[dict[str, float]] = []
    for number in range(options.processes + 1):
        command = [sys.executable, __file__, options.scenario, "--since", str(time.monotonic())]
        found = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
        if number:
            rounds.append(found)
    print(f"{options.scenario}, {options.processes} processes; ms      least   median")
    for found in rounds:
        found["total"] = sum(found[part] for part in PARTS)
    for part in (*PARTS, "total", "processor"):
        of = [found[part] for found in rounds]
        print(f"  {part:32}{1e3 * min(of):9.1f}{1e3 * statistics.median(of):9.1f}")


if __name__ == "__main__":
    main()
