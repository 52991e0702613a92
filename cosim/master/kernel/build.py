"""Compiling the kernel: named after a hash of its sources, so that no stale one is ever loaded."""

from __future__ import annotations

import hashlib
import tempfile
from pathlib import Path

from fmus.compiler import BuildError, Platform, compile_library, host_platform

FOLDER = Path(__file__).resolve().parent
SOURCES = FOLDER / "sources"
BUILT = FOLDER / "_built"


def kernel_path(target: Platform) -> Path:
    """Where the kernel for a platform lies once it is built."""
    digest = hashlib.sha256()
    for path in sorted(SOURCES.glob("*.[ch]")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return BUILT / f"kernel-{target.name}-{digest.hexdigest()[:16]}{target.suffix}"


def build_kernel(target: Platform) -> Path:
    """Compile the kernel for a platform unless it is there; older ones are removed.

    Raises:
        BuildError: the compiler refused, or there is none.
    """
    path = kernel_path(target)
    if path.exists():
        return path
    BUILT.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=BUILT) as name:
        scratch = Path(name) / path.name
        compile_library(target, scratch, sorted(SOURCES.glob("*.c")))
        for old in BUILT.glob(f"kernel-{target.name}-*{target.suffix}"):
            old.unlink(missing_ok=True)
        scratch.replace(path)
    return path


def find_kernel() -> Path:
    """The kernel for this machine; compiled now if its sources changed and a compiler is there.

    Raises:
        BuildError: there is none, and it cannot be built.
    """
    try:
        return build_kernel(host_platform())
    except OSError as error:
        raise BuildError(f"it is not built, and {BUILT} cannot be written: {error}") from None
