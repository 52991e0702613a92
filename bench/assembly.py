"""How loading, assembling and starting grow with the number of components, in a ring of them.

    uv run python bench/assembly.py [--sizes 8 64 512 4096] [--rounds 3] [--record] [--profile PART]

Half of the ring are masses, half virtual couplers. Every size and round runs in a process of its
own; the least of the rounds is printed, with the peak memory of that process. ``--record`` also
lays out the record of everything.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from cosim.testing.ring import ring_scenario

SIZES = (8, 64, 512, 1024, 2048, 4096)


def measure(size: int, *, record: bool, profiled: str | None) -> dict[str, float]:
    """Seconds of each part, in this process; ``ticks`` are 64 of the loop, a component."""
    import cProfile

    from cosim.master.run.simulation import assemble
    from cosim.record.writer import Recorder
    from cosim.run import peak_memory
    from cosim.scenario import load

    profile = cProfile.Profile()
    times: dict[str, float] = {}
    began = time.perf_counter()

    def lap(part: str) -> None:
        nonlocal began
        times[part] = time.perf_counter() - began
        if profiled == part:
            profile.disable()
            profile.print_stats("cumulative")
        began = time.perf_counter()

    def start(part: str) -> None:
        if profiled == part:
            profile.enable()

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "ring.yaml"
        file.write_text(ring_scenario(size, record='["*"]' if record else "[]"))
        began = time.perf_counter()
        start("load")
        scenario = load(file)
        lap("load")
        start("assemble")
        simulation = assemble(scenario)
        lap("assemble")
        with simulation:
            start("start")
            simulation.start(recorded=record)
            lap("start")
            if record:
                start("record")
                recorder = Recorder(Path(folder) / "run.h5", scenario.ticks)
                recorder.begin(simulation.groups, scenario.base_rate)
                lap("record")
                recorder.close()
            began = time.perf_counter()
            if not record:
                simulation.advance(64)
            lap("ticks")
    times["memory"] = peak_memory() / 1e6
    return times


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--sizes", type=int, nargs="+", default=SIZES)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--profile", metavar="PART", help="load, assemble, start or record")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        found = measure(options.one, record=options.record, profiled=options.profile)
        print(json.dumps(found))
        return
    parts = ["load", "assemble", "start", *(["record"] if options.record else [])]
    print("components" + "".join(f"{part:>11}" for part in parts) + "   together  growth     MB")
    before: tuple[int, float] | None = None
    for size in options.sizes:
        command = [sys.executable, __file__, "--one", str(size)]
        command += ["--record"] if options.record else []
        rounds = [
            json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
            for _ in range(options.rounds)
        ]
        best = min(rounds, key=lambda times: sum(times[part] for part in parts))
        together = sum(best[part] for part in parts)
        growth = ""
        if before is not None:
            ratio, doublings = together / before[1], size / before[0]
            growth = f"×{ratio:.2f} for ×{doublings:g}"
        print(
            f"{size:10}"
            + "".join(f"{best[part]:10.3f}s" for part in parts)
            + f"{together:10.3f}s  {growth:>14} {best['memory']:6.0f}"
        )
        before = size, together


if __name__ == "__main__":
    main()
