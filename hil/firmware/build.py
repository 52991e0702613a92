"""Compile the reference firmware as a shared library, to test it on this machine."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

FOLDER = Path(__file__).parent


def build(folder: Path, name: str = "cohaptic_device") -> Path:
    """The library of one reference, built with the C compiler of the ``ziglang`` package.

    Raises:
        subprocess.CalledProcessError: it does not compile.
    """
    library = folder / f"{name}.so"
    subprocess.run(
        [
            *(sys.executable, "-m", "ziglang", "cc", "-std=c11", "-O2", "-Wall", "-Wextra"),
            *("-Werror", "-shared", "-fPIC", "-o", str(library)),
            str(FOLDER / f"{name}.c"),
        ],
        check=True,
    )
    return library
