"""What a killed run has left in shared memory goes away; what a living one has there stays."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cosim.realtime.ring import Ring
from cosim.realtime.shared.leftovers import OLD_SECONDS, leftovers, remove_leftovers

CODE = """
import time
from cosim.realtime import ring
made = ring.Ring.create(4, 16)
print(made.path, flush=True)
time.sleep(60)
"""


@pytest.fixture
def ended() -> int:
    """The number of a process that is over."""
    process = subprocess.Popen([sys.executable, "-c", "pass"])
    process.wait()
    return process.pid


def ring(folder, name: str, *, age: float = 0.0):
    path = folder / f"cohaptic-ring-{name}"
    Ring.create(4, 16, path).close()
    os.utime(path, (time.time() - age,) * 2)
    return path


def test_a_dead_runs_description_and_its_rings_go(tmp_path, ended):
    dead, living = ring(tmp_path, "dead"), ring(tmp_path, "living")
    for process, path in ((ended, dead), (os.getpid(), living)):
        feed = tmp_path / f"cohaptic-live-{process}-7f.json"
        feed.write_text(json.dumps({"groups": [{"ring": str(path)}]}))
    other = tmp_path / "cohaptic-processor-0"
    other.write_text("")
    assert remove_leftovers(tmp_path) > 0
    assert not dead.exists()
    assert living.exists()
    assert other.exists()
    assert [path.name for path in tmp_path.glob("*.json")] == [
        f"cohaptic-live-{os.getpid()}-7f.json"
    ]


def test_an_undescribed_ring_goes_once_it_is_old(tmp_path):
    young, old = ring(tmp_path, "young"), ring(tmp_path, "old", age=2 * OLD_SECONDS)
    remove_leftovers(tmp_path)
    assert young.exists()
    assert not old.exists()


def test_a_ring_that_a_process_has_stays_however_old():
    process = subprocess.Popen([sys.executable, "-c", CODE], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    path = Path(process.stdout.readline().strip())
    os.utime(path, (time.time() - 2 * OLD_SECONDS,) * 2)
    assert path not in list(leftovers(path.parent))
    process.kill()
    process.wait()
    process.stdout.close()
    assert path in list(leftovers(path.parent))
    path.unlink()


def test_damaged_descriptions_harm_nothing(tmp_path, ended):
    (tmp_path / f"cohaptic-live-{ended}-1.json").write_text("{")
    (tmp_path / f"cohaptic-live-{ended}-2.json").write_text('{"groups": [{}]}')
    (tmp_path / "cohaptic-live-x.json").write_text("{}")
    remove_leftovers(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["cohaptic-live-x.json"]
