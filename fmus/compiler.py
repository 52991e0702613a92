"""The one compiler of everything native: ``zig cc`` from the ``ziglang`` wheel, for five platforms.

Libraries are freestanding: no C library, no C runtime, the same arithmetic everywhere. They are
bit-identical in what they compute because the target is always explicit (without one, zig would
use this machine's fused multiply-add), contraction is off and the libm is our own.
"""

from __future__ import annotations

import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fmus.cache import cache_directory


class BuildError(Exception):
    """A native library could not be built; the message holds what the compiler said."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Platform:
    """A system to build for; ``name`` is the FMI 3.0 platform tuple, ``fmi2`` FMI 2.0's folder."""

    name: str
    target: str
    suffix: str
    fmi2: str | None
    link: tuple[str, ...]


PLATFORMS = (
    Platform(
        name="x86_64-linux",
        target="x86_64-linux-gnu.2.17",
        suffix=".so",
        fmi2="linux64",
        link=("-nostdlib", "-fPIC"),
    ),
    Platform(
        name="aarch64-linux",
        target="aarch64-linux-gnu.2.17",
        suffix=".so",
        fmi2=None,
        link=("-nostdlib", "-fPIC"),
    ),
    Platform(
        name="x86_64-windows",
        target="x86_64-windows-gnu",
        suffix=".dll",
        fmi2="win64",
        link=("-nostdlib", "-lkernel32"),
    ),
    Platform(
        name="x86_64-darwin",
        target="x86_64-macos.11.0",
        suffix=".dylib",
        fmi2="darwin64",
        link=("-nostdlib", "-lSystem"),
    ),
    Platform(
        name="aarch64-darwin",
        target="aarch64-macos.11.0",
        suffix=".dylib",
        fmi2=None,
        link=("-nostdlib", "-lSystem"),
    ),
)

FLAGS = (
    "-std=gnu11",
    "-O2",
    "-ffp-contract=off",
    "-fno-math-errno",
    "-ffreestanding",
    "-fvisibility=hidden",
    "-fno-sanitize=undefined",
    "-Wall",
    "-Wextra",
    "-Wno-unused-parameter",
    "-Werror",
)


def host_platform() -> Platform:
    """The platform this process runs on.

    Raises:
        BuildError: there is none for it.
    """
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    system = {"win32": "windows", "darwin": "darwin"}.get(sys.platform, sys.platform)
    for candidate in PLATFORMS:
        if candidate.name == f"{machine}-{system}":
            return candidate
    known = ", ".join(candidate.name for candidate in PLATFORMS)
    raise BuildError(f"There is no native build for {machine}-{system}; there is one for {known}.")


def compile_library(
    target: Platform,
    output: Path,
    sources: Sequence[Path],
    *,
    include: Sequence[Path] = (),
    defines: Sequence[str] = (),
) -> None:
    """Compile C files into one shared library for ``target``.

    Raises:
        BuildError: the compiler refused, or it is not installed.
    """
    output.parent.mkdir(parents=True, exist_ok=True)
    command = [str(compiler_path()), "cc", "-target", target.target, *FLAGS, "-s", "-shared"]
    command += [f"-I{folder}" for folder in include]
    command += [f"-D{define}" for define in defines]
    command += [str(source) for source in sources]
    if target.suffix == ".dylib":
        command.append(f"-Wl,-install_name,@rpath/{output.name}")
    command += [*target.link, "-o", str(output)]
    cache = str(cache_directory() / "zig")
    environment = {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache}
    result = subprocess.run(
        command, capture_output=True, text=True, env=os.environ | environment, check=False
    )
    if result.returncode != 0:
        said = (result.stderr or result.stdout).strip()
        raise BuildError(f"{output.name} could not be compiled for {target.name}:\n{said}")


def compiler_path() -> Path:
    """The ``zig`` program.

    Raises:
        BuildError: it is not installed.
    """
    try:
        import ziglang  # only builds need the compiler
    except ImportError:
        raise BuildError(
            "The compiler is not installed; run 'uv sync', or 'pip install ziglang==0.17.1'."
        ) from None
    folder = Path(str(ziglang.__file__)).parent
    return folder / ("zig.exe" if sys.platform == "win32" else "zig")
