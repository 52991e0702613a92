"""The command line as a user starts it: a process of its own, in a folder of its own."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

COHAPTIC = [sys.executable, "-c", "from cosim.cli import main; main()"]


def cohaptic(
    *arguments: object, folder: Path, **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run it to its end; ``environment`` is added to this process's own."""
    return subprocess.run(
        [*COHAPTIC, *map(str, arguments)],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        stdin=subprocess.DEVNULL,
        env={**os.environ, **environment},
    )
