"""The peers: what installs them, and one run of one of them in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from fmus.cache import cache_directory

MASTERS = Path(__file__).with_name("masters")


@dataclass(frozen=True)
class Peer:
    """Another master."""

    name: str
    script: str
    packages: tuple[str, ...]
    computes: frozenset[str] = frozenset()
    """Kinds of systems in which its values are known to be ours, bit for bit."""
    digits: int = 17
    """Significant ones of the values that it gives."""


PEERS = {
    "fmpy": Peer("FMPy, low-level API", "fmpy_loop.py", (), frozenset({"one rate", "two rates"})),
    "container": Peer(
        "FMPy, container FMU",
        "fmpy_container.py",
        ("fmpy<0.3.28", "jinja2", "msgpack", "attrs"),  # later ones have no such classes
        frozenset({"one rate"}),
    ),
    "ecos": Peer("ecos", "ecos_master.py", ("ecospy", "tbb"), frozenset({"one rate"})),
    "libcosim": Peer(
        "libcosim", "libcosim_master.py", ("libcosimpy",), frozenset({"one rate", "two rates"})
    ),
    "cofmupy": Peer("CoFMuPy", "cofmupy_master.py", ("cofmupy",)),
    "mastersim": Peer("MasterSim", "mastersim_master.py", (), frozenset({"one rate"}), digits=14),
}
"""Why others do not compute the same is in docs/performance.md and docs/interop.md."""


@dataclass(frozen=True)
class Answer:
    """What a peer's run gave: its loop's seconds and last values, or why there are none."""

    seconds: float = 0.0
    values: tuple[float, ...] = ()
    cannot: str = ""
    """What it has no way to do."""
    failed: str = ""
    """How it ended that should not have."""


def environment(asked: Iterable[Peer]) -> Path:
    """The peers' own interpreter, with what the registry has of those asked for."""
    folder = cache_directory() / "bench-peers"
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run(["uv", "venv", "-q", "--python", "3.11", str(folder)], check=True)
    install = ["uv", "pip", "install", "-q", "--python", str(python), "fmpy"]
    subprocess.run([*install, *(each for peer in asked for each in peer.packages)], check=True)
    return python


def ask(python: Path, peer: Peer, system: Path, record: Path | None, mastersim: str) -> Answer:
    """Run ``peer`` over the system in a file; ``record`` is where its record goes."""
    where = [str(record)] if record else []
    done = subprocess.run(
        [str(python), str(MASTERS / peer.script), str(system), *where],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"MASTERSIM": mastersim},
    )
    lines = [line for line in done.stdout.splitlines() if line.startswith("{")]
    if done.returncode or not lines:
        said = [line for line in (done.stderr + done.stdout).splitlines() if line.strip()]
        return Answer(failed=f"it failed: {said[-1][:160] if said else done.returncode}")
    found = json.loads(lines[-1])
    if why := found.get("cannot"):
        return Answer(cannot=why)
    return Answer(found["seconds"], tuple(found["values"]))
