"""Programs of C around one model: it, the glue below the FMI functions and a ``main`` of ours.

These are hosted builds, for tools that watch a program; FMUs themselves are freestanding.
"""

from __future__ import annotations

import os
import subprocess
from collections.abc import Sequence
from pathlib import Path

from fmus.builder import FOLDER, model_files, support_files
from fmus.cache import cache_directory
from fmus.header import description_source, variables_header
from tests.support.fmus import fmu_support as support

GLUE = ("instance.c", "values.c", "snapshot.c", "fmi2.c", "fmi3.c")
NATIVE = Path(__file__).parent / "native"
NAMES = [name for name in (*support.MODELS, *support.PROBES) if name != "probe_failure"]  # crashes

FLAGS = ("-std=gnu11", "-O1", "-g", "-ffp-contract=off", "-fno-math-errno", "-fno-builtin")
FOLDERS = [FOLDER / each for each in ("fmi", "fmi/headers", "libm", "libm/musl")]
FOLDERS += sorted(each for each in (FOLDER / "shared").iterdir() if each.is_dir())


def compile_hosted(compiler: Sequence[str], *arguments: str | Path) -> None:
    """``compiler`` is a program and what it watches for."""
    command = [*compiler, *FLAGS, "-DCOHAPTIC_HOSTED", *(f"-I{folder}" for folder in FOLDERS)]
    cache = str(cache_directory() / "zig")
    environment = os.environ | {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache}
    subprocess.run([*command, *map(str, arguments)], check=True, env=environment)


def shared_objects(compiler: Sequence[str], folder: Path) -> list[Path]:
    """What all models share, compiled once."""
    made: list[Path] = []
    for path in [*support_files(), *(FOLDER / "fmi" / each for each in GLUE)]:
        made.append(folder / f"{path.stem}.o")
        compile_hosted(compiler, "-c", path, "-o", made[-1])
    return made


def model_program(
    compiler: Sequence[str], main: str, name: str, objects: Sequence[Path], folder: Path
) -> Path:
    """The program of ``main`` and one model, in ``folder``."""
    source = support.source(name)
    (folder / f"{name}_variables.h").write_text(variables_header(source.model))
    description = folder / "description.c"
    description.write_text(description_source(source.model, token="{x}", digest="0" * 64))
    program = folder / "program"
    own = [f"-I{source.folder}", f"-I{folder}", NATIVE / main, description, *model_files(source)]
    compile_hosted(compiler, *own, *objects, "-lm", "-o", program)
    return program
