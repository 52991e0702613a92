"""Our C that no bundled scenario reaches is watched: event mode, isolation, restarts, logs, arrays.

FMUs of others run with the kernel under gcc's sanitizers, and under valgrind: with clocks of every
kind, values of every type, in processes of their own, and one that answers anything to any call.
Every C file of ours is in one of the lanes that watch.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from cosim.master.kernel import build as kernel_build
from fmus.builder import FOLDER, model_files, support_files
from tests.support.fmus import fmu_support as support
from tests.support.fmus import watched
from tests.support.fmus.hosted import GLUE
from tests.support.fmus.valgrind import VALGRIND, complaints
from tests.support.fmus.watched_strangers import REACHED, SEEDS

HOUSE = Path(__file__).parents[3]
PROGRAM = (sys.executable, "-m", "tests.support.fmus.watched_strangers")
DONE = SEEDS + 11
needs_gcc = pytest.mark.skipif(
    sys.platform != "linux" or shutil.which("gcc") is None, reason="gcc brings the sanitizers"
)
LEFT_OUT = {"development.c", "platform.c", *watched.FREESTANDING}
"""What a model and the kernel have in place of a C library, and whoever builds an FMU of theirs."""


def test_every_c_file_is_in_a_lane_that_watches() -> None:
    """Of models and what they share; and of the kernel, which has to be run line by line below."""
    names = (*support.MODELS, *support.PROBES)
    found = {
        *(path for name in names for path in model_files(support.source(name))),
        *support_files(),
        *(FOLDER / "fmi" / name for name in GLUE),
        *kernel_build.SOURCES.glob("*.c"),
    }
    every = {*FOLDER.rglob("*.c"), *kernel_build.SOURCES.glob("*.c")}
    assert {path.name for path in every - found} <= LEFT_OUT


@pytest.fixture(scope="module")
def lines_run(tmp_path_factory: pytest.TempPathFactory) -> dict[str, float]:
    """The share (%) of the lines of each of the kernel's files, after everything was run."""
    folder = tmp_path_factory.mktemp("sanitized")
    more = folder / "reached.c"
    more.write_text(REACHED)
    watched.build_kernel(folder, (*watched.SANITIZERS, "--coverage"), [more])
    asan = subprocess.run(
        ["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True
    )
    # Python itself leaks at its end; memory is watched for everything else.
    given = {"LD_PRELOAD": asan.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}
    done = subprocess.run(
        [*PROGRAM, str(folder)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | given,
        cwd=HOUSE,
    )
    assert done.returncode == 0, done.stderr[-4000:]
    assert len(done.stdout.split()) == DONE
    counted = subprocess.run(
        ["gcov", "-n", *(path.name for path in folder.glob("*.gcda"))],
        capture_output=True,
        text=True,
        check=True,
        cwd=folder,
    )
    found = re.findall(r"File '(.*)'\nLines executed:([\d.]+)%", counted.stdout)
    return {Path(name).name: float(share) for name, share in found}


@needs_gcc
@pytest.mark.slow
def test_no_sanitizer_complains_and_nearly_every_line_is_run(lines_run: dict[str, float]) -> None:
    for path in kernel_build.SOURCES.glob("*.c"):
        if path.name not in watched.FREESTANDING:
            assert lines_run[path.name] > 70, lines_run


@pytest.mark.exhaustive
@pytest.mark.skipif(
    sys.platform != "linux" or VALGRIND is None, reason="valgrind has to be installed"
)
def test_valgrind_finds_nothing(tmp_path: Path) -> None:
    watched.build_kernel(tmp_path)
    found, done = complaints([*PROGRAM, tmp_path], tmp_path, cwd=HOUSE)
    assert found == []
    assert done.returncode == 0, done.stderr[-4000:]
    assert len(done.stdout.split()) == DONE
