"""A sweep of 1,000 on Dask: a worker, a run in native code, and the scheduler die midway.

What was under way is run again, and nothing else.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from cosim.sweep.results.store import RESULTS_FILE
from tests.support.sweep.parts import SCENARIO
from tests.support.sweep.written import table_in

RUNS = 1000
DEADLY = 100
"""The point whose run kills its process with a segmentation fault."""
ROOT = Path(__file__).parents[3]


class Cluster:
    """A scheduler and workers in processes of their own, each of which can be killed."""

    def __init__(self, folder: Path, stack: ExitStack, counted: Path) -> None:
        self.folder, self.stack, self.counted = folder, stack, counted
        self.file = folder / "scheduler.json"
        self.workers: list[subprocess.Popen[bytes]] = []

    def start(self) -> str:
        self.file.unlink(missing_ok=True)
        self.scheduler = self.process("dask_scheduler", "--port", "0", "--no-dashboard")
        until(self.file.exists)
        self.workers = [self.worker() for _ in range(2)]
        address: str = json.loads(self.file.read_text())["address"]
        return address

    def worker(self) -> subprocess.Popen[bytes]:
        return self.process(
            "dask_worker",
            "--nthreads",
            "1",
            "--no-dashboard",
            "--nanny",  # which begins a new worker where one has died
            "--death-timeout",
            "60",
        )

    def process(self, name: str, *arguments: str) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            [
                *(sys.executable, "-m", f"distributed.cli.{name}", *arguments),
                *("--scheduler-file", str(self.file)),
            ],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=self.folder,
            env={**os.environ, "PYTHONPATH": str(ROOT), "COUNT_RUNS": str(self.counted)},
        )
        self.stack.callback(kill, process)
        return process


def kill(process: subprocess.Popen[bytes]) -> None:
    process.send_signal(signal.SIGKILL)
    process.wait()


def until(holds: Callable[[], bool], seconds: float = 150.0) -> None:
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, "it did not come about in time"
        time.sleep(0.01)


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Cluster]:
    with ExitStack() as stack:
        yield Cluster(tmp_path, stack, tmp_path / "counted")


def sweep(folder: Path, out: Path, *more: str) -> subprocess.Popen[bytes]:
    scenario = folder / "test.yaml"
    scenario.write_text(json.dumps({**SCENARIO, "duration": 0.5}))
    arguments = ["sweep", str(scenario), "--vary", f"part.gain=1..{RUNS}", "--measure"]
    arguments += ["hand.position:rms", "--check-every", "0", "--no-figure", "--out", str(out)]
    arguments += ["--set", f"components.part.parameters.deadly={DEADLY}"]
    return subprocess.Popen(
        [
            sys.executable,
            "-W",
            "ignore",
            "-c",
            "from cosim.cli import main; main()",
            *arguments,
            *more,
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )


def status(process: subprocess.Popen[bytes]) -> int:
    process.communicate(timeout=120)
    return process.returncode


def known(out: Path) -> int:
    file = out / RESULTS_FILE
    return len(file.read_bytes().splitlines()) if file.exists() else 0


@pytest.mark.slow
def test_a_killed_worker_and_a_killed_scheduler(tmp_path: Path, cluster: Cluster) -> None:
    whole = tmp_path / "whole"
    assert status(sweep(tmp_path, whole, "--workers", "2")) == 1
    assert Counter(row["status"] for row in table_in(whole)) == {"good": RUNS - 1, "crashed": 1}
    crashed = table_in(whole)[DEADLY - 1]
    assert "part" in crashed["message"], "who was at work is named, also by the cluster"

    out = tmp_path / "cluster"
    address = cluster.start()
    first = sweep(tmp_path, out, "--scheduler", address)
    until(lambda: known(out) > 40)
    kill(cluster.workers[0])
    cluster.worker()
    until(lambda: known(out) > 400)
    kill(cluster.scheduler)
    _, said = first.communicate(timeout=60)
    assert b"Traceback" not in said
    assert first.returncode == 1
    assert b"this sweep with the same --out" in said
    before = known(out)
    assert 400 < before < RUNS

    for worker in cluster.workers[1:]:
        kill(worker)
    assert status(sweep(tmp_path, out, "--scheduler", cluster.start())) == 1
    assert table_in(out) == table_in(whole)
    lines = (out / RESULTS_FILE).read_text().splitlines()
    keys = Counter(json.loads(line)["key"] for line in lines)
    assert len(keys) == RUNS
    assert sum(keys.values()) <= RUNS + 1, "what crashed is tried again, and nothing else"
    begun = Counter(cluster.counted.read_text().splitlines())
    # Chunks of 20 that were under way at two workers when one, and then the scheduler, was killed,
    # and at each of four crashes, after which its chunk kills no worker.
    assert sum(begun.values()) - RUNS <= 2 * 4 * 20 + 2 * 5 * 20


@pytest.mark.slow
def test_nobody_at_the_address_is_a_sentence(tmp_path: Path) -> None:
    process = sweep(tmp_path, tmp_path / "out", "--scheduler", "tcp://127.0.0.1:1")
    _, said = process.communicate(timeout=60)
    assert process.returncode == 2
    assert b"there is no scheduler at tcp://127.0.0.1:1" in said
