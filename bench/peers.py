"""The same rings and chains of FMUs in other masters, first compared and then timed.

    uv run python bench/peers.py [--sizes 8 64] [--ticks 4096] [--rounds 3]

Masses (our FMU ``hand``, FMI 2.0) push one another: the position of each is the force on the next.
Peers are installed into an environment of their own in the cache, as the registries have them:
FMPy's low-level API, ecos and libcosim. Every peer runs in a process of its own, rounds are
interleaved, and what is printed are microseconds a tick and the ratio to a bare C loop over the
same FMUs. A peer whose last positions are not those of the others, bit for bit, is shown as such.
Exit status 1 where one differs that is known to agree.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from kernel import measure  # bench/kernel.py, beside this file
from rings import scenario

import fmus
from cosim.base.recording import MemorySink
from cosim.master.run.simulation import assemble
from cosim.scenario import Scenario
from fmus.cache import cache_directory

PACKAGES = ("fmpy", "libcosimpy", "ecospy", "tbb")
STEP = 1.0 / 1024
PEERS = {"FMPy, low-level API": "fmpy", "ecos": "ecos", "libcosim": "libcosim"}
DIFFERENT = {"libcosim"}
"""Hands its first values over in another step (docs/performance.md)."""
SCRIPT = Path(__file__).with_name("peers_there.py")


def ours(written: Scenario) -> list[float]:
    """The last positions."""
    sink = MemorySink()
    with assemble(written) as simulation:
        simulation.run(sink)
    return [float(sink.signal(f"{name}.position")[-1]) for name in written.components]


def there(python: Path, peer: str, size: int, shape: str, ticks: int) -> tuple[float, list[float]]:
    """Seconds of a peer's loop, and its last positions."""
    done = subprocess.run(
        [
            *(str(python), str(SCRIPT), peer, str(fmus.find("hand", "fmi2"))),
            *(str(size), shape, str(ticks)),
        ],
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        raise SystemExit(f"{peer} failed: {done.stderr[-600:]}")
    found = json.loads(done.stdout.splitlines()[-1])
    return found["seconds"], found["positions"]


def environment() -> Path:
    """The peers' own interpreter."""
    folder = cache_directory() / "bench-peers"
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run(["uv", "venv", "-q", str(folder)], check=True)
    install = ["uv", "pip", "install", "-q", "--python", str(python), *PACKAGES]
    subprocess.run(install, check=True)
    return python


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sizes", nargs="+", type=int, default=[8, 64])
    parser.add_argument("--ticks", type=int, default=4096)
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    python = environment()
    wrong: set[str] = set()
    for shape in ("ring", "chain"):
        for size in options.sizes:
            with tempfile.TemporaryDirectory() as name:
                folder = Path(name)
                written = scenario(size, shape, options.ticks, folder)
                print(f"{shape} of {size}, {options.ticks} ticks, {options.rounds} rounds:")
                wrong |= compare(
                    written,
                    lambda peer, size=size, shape=shape: there(
                        python, peer, size, shape, options.ticks
                    ),
                    options.rounds,
                    folder,
                )
    for name in sorted(wrong - DIFFERENT):
        print(f"{name} computes something else than it used to", file=sys.stderr)
    return 1 if wrong - DIFFERENT else 0


def compare(
    written: Scenario,
    ask: Callable[[str], tuple[float, list[float]]],
    rounds: int,
    folder: Path,
) -> set[str]:
    """Run everybody in turn and print the least of each; ``ask`` runs a peer.

    Returns those that computed something else.
    """
    ticks = written.ticks
    expected = ours(written)
    times: dict[str, list[float]] = {}
    wrong: dict[str, str] = {}
    for _ in range(rounds):
        for recorded, name in ((False, "cohaptic"), (True, "cohaptic, recording")):
            with tempfile.TemporaryDirectory(dir=folder) as own:
                master, bare = measure(written, Path(own), recorded=recorded)
            times.setdefault(name, []).append(master)
            times.setdefault("bare C", []).append(bare)
        for name, peer in PEERS.items():
            seconds, positions = ask(peer)
            if positions != expected:
                first = next(n for n, p in enumerate(positions) if p != expected[n])
                wrong[name] = f"mass {first} at {positions[first]!r}, here {expected[first]!r}"
            times.setdefault(name, []).append(seconds)
    base = min(times["bare C"])
    for name, found in times.items():
        least = min(found) / ticks * 1e6
        said = wrong.get(name) or f"{min(found) / base:8.2f} × bare C"
        print(f"  {name:<24} {least:10.3f} us a tick  {said}")
    return set(wrong)


if __name__ == "__main__":
    sys.exit(main())
