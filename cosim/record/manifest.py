"""manifest.json: what ran, with which versions, where, and how it ended.

It is written when the run starts, with ``exit`` null, and replaced in one step when it ends; a run
whose ``exit`` is still null was killed, or goes on.
"""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cosim.base.system.installed import version_of
from cosim.record.reader import MANIFEST_FILE
from cosim.scenario import Scenario

MANIFEST_VERSION = 1
PACKAGES = ("cohaptic", "numpy", "h5py", "fmpy")


def describe(scenario: Scenario, components: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The manifest of a run that starts now.

    ``components`` says for each what it was computed by: kind, source, and for an FMU its version,
    FMI version and SHA-256.
    """
    return {
        "manifest": MANIFEST_VERSION,
        "scenario": {
            "name": scenario.name,
            "title": scenario.title,
            "file": str(scenario.file),
            "seed": scenario.seed,
            "base_rate": str(scenario.base_rate),
            "duration": float(scenario.duration),
            "start_time": float(scenario.start_time),
            "ticks": scenario.ticks,
        },
        "components": components,
        "versions": {"python": platform.python_version()} | _versions(),
        "platform": {
            "system": platform.platform(),
            "machine": platform.machine(),
            "cpus": os.cpu_count(),
        },
        "git": _checkout(),
        "command": sys.argv,
        "process": os.getpid(),
        "started": _now(),
        "ended": None,
        "exit": None,
        "timing": None,
        "channels": None,
        "deadlines": None,
    }


def conclude(manifest: dict[str, Any], *, status: int, message: str, ticks: int) -> None:
    """Add how the run ended: the exit status it stands for, why, and the ticks it reached."""
    manifest["ended"] = _now()
    manifest["exit"] = {"status": status, "message": message, "ticks": ticks}


def write_manifest(folder: Path, manifest: Mapping[str, Any]) -> None:
    """Write or replace the folder's manifest in one step."""
    write_json(folder / MANIFEST_FILE, manifest)


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON file in one step."""
    text = json.dumps(content, indent=2, ensure_ascii=False) + "\n"
    replace_file(path, lambda scratch: scratch.write_text(text, encoding="utf-8"))


def replace_file(path: Path, write: Callable[[Path], object]) -> None:
    """Let ``write`` fill a file beside ``path`` that takes its place: all of it, or nothing.

    Raises:
        OSError: it cannot be written; ``path`` is as it was.
    """
    scratch = path.with_name(f"{path.name}.new")
    try:
        write(scratch)
        scratch.replace(path)
    except BaseException:
        with suppress(OSError):
            scratch.unlink(missing_ok=True)
        raise


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _versions() -> dict[str, str]:
    found = {name: version_of(name) for name in PACKAGES}
    return {name: version for name, version in found.items() if version is not None}


def _checkout() -> dict[str, Any] | None:
    """Commit of the source checkout that runs and whether it has changes; none if installed."""
    root = Path(__file__).parents[2]
    if not (root / ".git").exists():
        return None

    command = ["git", "-C", str(root), "status", "--porcelain=v2", "--branch"]
    try:
        told = subprocess.run(
            [*command, "--untracked-files=no"],
            capture_output=True,
            text=True,
            check=True,
            timeout=5,
        ).stdout.splitlines()
    except (OSError, subprocess.SubprocessError):
        return None
    commit = next((line.split()[-1] for line in told if line.startswith("# branch.oid ")), "")
    return {"commit": commit, "changed": any(not line.startswith("#") for line in told)}
