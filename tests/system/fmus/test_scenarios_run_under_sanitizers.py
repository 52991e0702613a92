"""Every bundled scenario runs with the kernel and all FMUs under gcc's sanitizers.

Addresses and undefined behaviour, in one process, so that second runs are seen as well.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.support.fmus import watched

pytestmark = [
    pytest.mark.exhaustive,
    pytest.mark.skipif(
        sys.platform != "linux" or shutil.which("gcc") is None, reason="gcc brings the sanitizers"
    ),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("sanitized")
    watched.build(folder, watched.SANITIZERS)
    return folder


def run(*command: str) -> subprocess.CompletedProcess[str]:
    found = subprocess.run(
        ["gcc", "-print-file-name=libasan.so"], capture_output=True, text=True, check=True
    )
    # Python itself leaks at its end; memory is watched for everything else.
    environment = {"LD_PRELOAD": found.stdout.strip(), "ASAN_OPTIONS": "detect_leaks=0"}
    return subprocess.run(
        [sys.executable, *command],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | environment,
        cwd=Path(__file__).parents[3],
    )


def test_every_bundled_scenario(folder: Path) -> None:
    done = run("-m", "tests.support.fmus.watched", str(folder))
    assert done.returncode == 0, done.stderr[-4000:]
    assert len(done.stdout.split()) >= 28


def test_the_sanitizers_are_there(folder: Path) -> None:
    """A log that was given back and is written all the same is noticed."""
    text = (
        "import ctypes, sys; k = ctypes.CDLL(sys.argv[1]); k.kernel_isolated.restype = "
        "ctypes.c_void_p; k.kernel_isolated(2, 5000000, 0)"
    )
    done = run("-c", text, str(folder / watched.KERNEL))
    assert done.returncode != 0
    assert "Sanitizer" in done.stderr or "runtime error" in done.stderr
