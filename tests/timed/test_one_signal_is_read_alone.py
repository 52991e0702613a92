"""One signal of a minute's record, opened by its name, takes five milliseconds at most."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np

from cosim.master.run.simulation import assemble
from cosim.reading import load
from cosim.record.layout import lay_out, rows_in, write_cells
from cosim.record.manifest import describe, write_manifest
from cosim.record.reader import RUN_FILE, open_run

MOST = 5e-3
"""Of processor time (s), the least of ``TRIES``; to read every name took ten times as long."""
TRIES = 15
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


def test_one_signal_of_a_minute_takes_five_milliseconds(tmp_path: Path) -> None:
    assert minute(tmp_path) > 380
    least = np.inf
    for _ in range(TRIES):
        began = time.process_time()
        with open_run(tmp_path) as run:
            values = run[SIGNAL].values
        least = min(least, time.process_time() - began)
        assert values.shape == (61_440,)
    print(f"{1e3 * least:.2f} ms")
    assert least <= MOST
