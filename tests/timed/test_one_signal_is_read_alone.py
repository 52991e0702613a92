"""One signal of a minute's record, by its name, costs little more than its row by its path."""

from __future__ import annotations

import time
from pathlib import Path

import h5py
import numpy as np

from cosim.master.run.simulation import assemble
from cosim.reading import load
from cosim.record.layout import lay_out, rows_in, write_cells
from cosim.record.manifest import describe, write_manifest
from cosim.record.reader import RUN_FILE, open_run

MOST = 9.0
"""Times the row by its path, each the least of ``TRIES`` in turn; every name takes 60 times that.

A ratio: both are slow in the same minute. 2.4 ms to 0.43 ms (5.6) where this was written.
"""
TRIES = 25
SIGNAL = "vr_a.box_pose.y"


def minute(folder: Path) -> int:
    """The record of a minute of the box, zeros all of it; returns how many signals it has."""
    scenario = load("two_users_box", sets=["duration=60 s"])
    with assemble(scenario) as simulation:
        groups = simulation.groups
    rows = [rows_in(scenario.ticks, group.period) for group in groups]
    layouts = lay_out(folder / RUN_FILE, groups, scenario.base_rate, rows)
    with (folder / RUN_FILE).open("r+b", buffering=0) as file:
        for layout, count in zip(layouts, rows, strict=True):
            write_cells(file, layout.rows_offset, np.array([count]))
    write_manifest(folder, describe(scenario, {}))
    return sum(len(group.columns) for group in groups)


def by_name(folder: Path) -> int:
    with open_run(folder) as run:
        return run[SIGNAL].values.size


def by_path(folder: Path) -> int:
    with h5py.File(folder / RUN_FILE) as file:
        return file["control/float64"][5, :].size


def test_one_signal_of_a_minute_is_read_alone(tmp_path: Path) -> None:
    assert minute(tmp_path) > 380
    least = {by_name: np.inf, by_path: np.inf}
    for read in (by_name, by_path) * TRIES:
        began = time.process_time()
        assert read(tmp_path) == 61_440
        least[read] = min(least[read], time.process_time() - began)
    print(f"{1e3 * least[by_name]:.2f} ms by its name, {1e3 * least[by_path]:.2f} by its path")
    assert least[by_name] <= MOST * least[by_path]
