"""Every model and the glue under AddressSanitizer and UndefinedBehaviorSanitizer.

Uses the system's gcc or clang, which bring the sanitizers' libraries; without one, zig's undefined
behaviour traps alone. The programs are hosted builds; FMUs themselves are freestanding.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from fmus.builder import FOLDER, model_files, support_files
from fmus.cache import cache_directory
from fmus.compiler import compiler_path
from fmus.header import description_source, variables_header
from tests.support.fmus import fmu_support as support

GLUE = ("instance.c", "values.c", "snapshot.c", "fmi2.c", "fmi3.c")
NATIVE = Path(__file__).parents[2] / "support" / "fmus" / "native"
NAMES = [name for name in (*support.MODELS, *support.PROBES) if name != "probe_failure"]  # crashes
COMPILER = shutil.which("gcc") or shutil.which("clang")


FLAGS = ("-std=gnu11", "-O1", "-g", "-ffp-contract=off", "-fno-math-errno", "-fno-builtin")
FOLDERS = [FOLDER / each for each in ("fmi", "fmi/headers", "libm", "libm/musl")]
FOLDERS += sorted((FOLDER / "shared").iterdir())


def compile_with(*arguments: str | Path) -> None:
    if COMPILER is not None:
        command = [COMPILER, "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    else:
        command = [str(compiler_path()), "cc", "-fsanitize=undefined", "-fsanitize-trap=undefined"]
    command += [*FLAGS, "-DCOHAPTIC_HOSTED", *(f"-I{folder}" for folder in FOLDERS)]
    cache = str(cache_directory() / "zig")
    environment = os.environ | {"ZIG_GLOBAL_CACHE_DIR": cache, "ZIG_LOCAL_CACHE_DIR": cache}
    subprocess.run([*command, *map(str, arguments)], check=True, env=environment)


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """What all models share, compiled once."""
    folder = tmp_path_factory.mktemp("objects")
    made: list[Path] = []
    for path in [*support_files(), *(FOLDER / "fmi" / each for each in GLUE)]:
        made.append(folder / f"{path.stem}.o")
        compile_with("-c", path, "-o", made[-1])
    return made


def run_with(main: str, name: str, objects: list[Path], folder: Path) -> int:
    """The number that the program says, which is ``main`` and one model."""
    source = support.source(name)
    (folder / f"{name}_variables.h").write_text(variables_header(source.model))
    description = folder / "description.c"
    description.write_text(description_source(source.model, token="{x}", digest="0" * 64))
    program = folder / "program"
    own = [f"-I{source.folder}", f"-I{folder}", NATIVE / main, description, *model_files(source)]
    compile_with(*own, *objects, "-lm", "-o", program)
    result = subprocess.run([program], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    return int(result.stdout)


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_no_sanitizer_complains(name: str, objects: list[Path], tmp_path: Path) -> None:
    assert run_with("exercise.c", name, objects, tmp_path) > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_hostile_importer_breaks_nothing(name: str, objects: list[Path], tmp_path: Path) -> None:
    """Two thousand instances, and forty thousand calls that keep no rule."""
    assert run_with("hostile.c", name, objects, tmp_path) > 1000
