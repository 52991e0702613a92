"""What a run does not need until its first tick is not imported until then; nor for a glance."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

LATER = {
    *("asyncio", "concurrent", "cryptography", "fmpy", "http", "jinja2", "lxml", "matplotlib"),
    *("multiprocessing", "pandas", "rich", "ruamel", "scipy", "ssl", "xarray"),
    *("hil", "cosim.link", "cosim.realtime", "cosim.station", "cosim.theory", "cosim.thesis"),
    *("cosim.report.overview", "cosim.testing", "fmus.archive", "fmus.builder", "fmus.table"),
}
ALSO_LATER = {"cosim.master", "cosim.scenario", "h5py", "numpy", "pydantic", "yaml"}

FIRST_TICK = """
import os, sys
from cosim.master.run.execution.kernel_run import KernelRun

def first(*_, **__):
    with open(os.environ["SEEN"], "w") as file:
        print(*sys.modules, file=file)
    os._exit(0)

KernelRun.run_chunk = first
"""
RUN = "from cosim.cli import main; main()"


def _modules(seen: Path, program: str, *words: str) -> set[str]:
    """Every module, and every package around one, that ``program`` names in the file ``seen``."""
    subprocess.run(
        [sys.executable, "-c", program, *words],
        capture_output=True,
        check=False,  # the run may be a process of its own, and its end there a failure
        env={**os.environ, "SEEN": str(seen)},
    )
    parts = [name.split(".") for name in seen.read_text().split()]
    return {".".join(names[:count]) for names in parts for count in range(1, len(names) + 1)}


@pytest.fixture(name="_filled", scope="module")
def _fill(tmp_path_factory: pytest.TempPathFactory) -> None:
    """What is kept between runs is kept: archives unpacked, descriptions read, sources judged."""
    folder = tmp_path_factory.mktemp("first") / "run"
    words = ["run", "two_users_box", "--duration", "0.01", "--no-figure", "--out", str(folder)]
    subprocess.run([sys.executable, "-c", RUN, *words], capture_output=True, check=False)


@pytest.mark.usefixtures("_filled")
def test_a_run_from_the_command_line(tmp_path: Path) -> None:
    words = ["run", "two_users_box", "--no-figure", "--out", str(tmp_path / "run")]
    loaded = _modules(tmp_path / "seen", FIRST_TICK + RUN, *words)
    assert {"cosim.record.writer", "h5py", "numpy"} <= loaded, "it did come to its first tick"
    assert not loaded & LATER


@pytest.mark.usefixtures("_filled")
def test_a_run_from_a_program(tmp_path: Path) -> None:
    program = (
        "import cohaptic; from pathlib import Path; "
        "cohaptic.run(cohaptic.load('two_users_box'), Path(sys.argv[1]))"
    )
    loaded = _modules(tmp_path / "seen", FIRST_TICK + program, str(tmp_path / "run"))
    assert {"cosim.record.writer", "h5py", "numpy"} <= loaded, "it did come to its first tick"
    assert not loaded & (LATER | {"click"})


def test_the_list_of_commands(tmp_path: Path) -> None:
    program = (
        "import atexit, os, sys; "
        "atexit.register(lambda: print(*sys.modules, file=open(os.environ['SEEN'], 'w'))); " + RUN
    )
    assert not _modules(tmp_path / "seen", program, "--help") & (LATER | ALSO_LATER)
