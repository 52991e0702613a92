"""Every model and the glue under AddressSanitizer and UndefinedBehaviorSanitizer.

Uses the system's gcc or clang, which bring the sanitizers' libraries; without one, zig's undefined
behaviour traps alone.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from fmus.compiler import compiler_path
from tests.support.fmus.hosted import NAMES, model_program, shared_objects

COMPILER = shutil.which("gcc") or shutil.which("clang")
WATCHING = (
    [COMPILER, "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]
    if COMPILER is not None
    else [str(compiler_path()), "cc", "-fsanitize=undefined", "-fsanitize-trap=undefined"]
)


@pytest.fixture(scope="module")
def objects(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return shared_objects(WATCHING, tmp_path_factory.mktemp("objects"))


def run_with(main: str, name: str, objects: list[Path], folder: Path) -> int:
    """The number that the program says, which is ``main`` and one model."""
    program = model_program(WATCHING, main, name, objects, folder)
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
