"""Twice the components take at most 2.3 times as long to load, assemble and start."""

from __future__ import annotations

import time
from pathlib import Path

from cosim.master.run.simulation import assemble
from cosim.scenario import load
from cosim.testing.ring import ring_scenario


def seconds(file: Path) -> float:
    """Processor time (s) from the file to the first tick."""
    began = time.process_time()
    with assemble(load(file)) as simulation:
        simulation.run(until=1)
    return time.process_time() - began


def test_twice_the_components_take_twice_as_long(tmp_path: Path) -> None:
    files = [tmp_path / f"{size}.yaml" for size in (1024, 2048)]
    for file in files:
        file.write_text(ring_scenario(int(file.stem)), encoding="utf-8")
    seconds(files[0])  # imports, and the caches
    once, twice = (min(seconds(file) for _ in range(3)) for file in files)
    assert twice <= 2.3 * once
