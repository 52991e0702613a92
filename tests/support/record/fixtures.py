"""Synthetic runs for every test of the record."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.base.recording import Column, RecordGroup
from tests.support.record.synthetic_run import write

HELD = Column(name="lan.held", unit="m/s", is_float=True)


@pytest.fixture
def small_run(tmp_path: Path) -> Path:
    """Two rates; a ramp, a sine, an integer that counts, and a held value at 128 Hz."""
    ticks = np.arange(2048)
    fast = np.stack(
        [
            (0.001 * ticks).view(np.int64),
            np.sin(2 * np.pi * 4 * ticks / 1024).view(np.int64),
            ticks // 512,
        ],
        axis=1,
    )
    slow = np.stack([(ticks[::8] * 0.5).view(np.int64)], axis=1)
    groups = (
        RecordGroup(
            name="control",
            period=1,
            columns=(
                Column(name="a.ramp", unit="m", is_float=True, description="a ramp"),
                Column(name="a.sine", unit="N", is_float=True),
                Column(name="a.state", unit=None, is_float=False),
            ),
        ),
        RecordGroup(name="network", period=8, columns=(HELD,)),
    )
    write(tmp_path / "run" / "run.h5", groups, (fast, slow))
    return tmp_path / "run"
