"""One figure of a measurement: round trips over time, their distribution, loss in bursts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from cosim.link.netchar.measurement import RETURNED, SENT, NetworkMeasurement
from cosim.link.netchar.statistics import Characteristics


def draw(measurement: NetworkMeasurement, found: Characteristics, path: Path) -> None:
    """Write the figure to ``path`` (png, pdf or svg by its ending)."""
    from matplotlib.figure import Figure

    figure: Any = Figure(figsize=(9.0, 6.0), layout="constrained")
    grid = figure.add_gridspec(2, 2)
    over_time, spread, bursts = (
        figure.add_subplot(grid[0, :]),
        figure.add_subplot(grid[1, 0]),
        figure.add_subplot(grid[1, 1]),
    )
    columns = measurement.kept.columns
    came = columns[RETURNED] > 0
    seconds = (columns[SENT] - measurement.first_sent) * 1e-9
    trips = (columns[RETURNED] - columns[SENT]) * 1e-6
    # A long measurement is drawn as the envelope of a few thousand bins.
    step = max(1, int(came.sum()) // 4000)
    times, values = seconds[came][::step], trips[came]
    highest = values
    if step > 1:
        highest = np.maximum.reduceat(values, np.arange(0, len(values), step))
    over_time.plot(times, highest, ".", markersize=2, color="C0", label="returned")
    over_time.plot(
        seconds[~came], np.zeros(int((~came).sum())), "|", color="C3", markersize=10, label="lost"
    )
    over_time.set(xlabel="time (s)", ylabel="round trip (ms)")
    over_time.legend(loc="upper right")
    if len(values):
        spread.hist(values, bins=100, color="C0")
    spread.set(xlabel="round trip (ms)", ylabel="packets", yscale="log")
    bursts.bar(list(found.loss.bursts), list(found.loss.bursts.values()), color="C3")
    bursts.set(xlabel="packets lost in a row", ylabel="how often")
    if found.round_trip is not None:
        figure.suptitle(
            f"round trip {found.round_trip.mean * 1e3:.3f} ms, "
            f"jitter {found.round_trip.rms_jitter * 1e3:.3f} ms rms, "
            f"loss {found.loss.packets} of {found.sent} at {found.rate:g} packets a second"
        )
    figure.savefig(path, dpi=150)
