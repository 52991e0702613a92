"""The delays that packets really had, as a recorded trace for the simulated channel.

What two stations measured can so be simulated: the copies of a merged run have to agree as that
simulation says, packet by packet.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import floor
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cosim.record.reader import Run
from cosim.scenario import Channel, load

MEASURED_FILE = "measured.yaml"
"""An overlay for the merged run's scenario."""


def write_traces(folder: Path, scenario: Path, runs: Mapping[str, Run]) -> Path | None:
    """Write what became of every packet; the overlay's path, or ``None`` where that is not known.

    ``runs`` holds the stations' records by name. A station that joined late, or a run that did not
    record the links' facts, cannot be simulated from its first tick.
    """
    if any(int(run.manifest["link"]["first_tick"]) != 0 for run in runs.values()):
        return None
    lines: list[str] = []
    for channel in load(str(scenario)).channels.values():
        files: dict[str, str] = {}
        for way, (source, target) in _ways(channel):
            if target not in runs:
                continue
            fates = fates_of(runs[target], source, channel)
            if fates is None:
                continue
            files[way] = f"{channel.name}.{way}.txt"
            text = "".join(f"{line}\n" for line in _written(fates, runs[target].base_rate))
            (folder / files[way]).write_text(text, encoding="utf-8")
        if len(files) == 2:
            lines += [f"  {channel.name}:", "    trace:"]
            lines += [f"      {way}: {file}" for way, file in files.items()]
    if not lines:
        return None
    path = folder / MEASURED_FILE
    path.write_text("\n".join(["cohaptic: 1", "channels:", *lines, ""]), encoding="utf-8")
    return path


def _ways(channel: Channel) -> Iterator[tuple[str, tuple[str, str]]]:
    first, second = channel.between
    yield "forward", (first, second)
    yield "backward", (second, first)


def fates_of(run: Run, source: str, channel: Channel) -> NDArray[np.int64] | None:
    """Delay of each packet in base ticks, -1 where it was never shown; by its number.

    A packet has the number of the sample that it brings, in every session and wherever the two
    grids are; its delay is the difference of the ticks at which it was sampled and shown. ``None``
    where that is not recorded, or where a packet was shown before its tick.
    """
    sample = f"{_component(run, source)}.{channel.name}.sample"
    if sample not in run:
        return None
    number = np.asarray(run[sample].values, dtype=np.int64)
    shown = np.flatnonzero((np.diff(number, prepend=-1) != 0) & (number >= 0))
    delay = shown - number[shown] * channel.period
    if np.any(delay < 0):
        return None
    fates = np.full(-(-len(number) // channel.period), -1, dtype=np.int64)
    fates[number[shown]] = delay
    return fates


def _component(run: Run, source: str) -> str:
    return str(run.manifest["link"]["peers"].get(source, {}).get("component", f"link_{source}"))


def _written(fates: NDArray[np.int64], base_rate: Fraction) -> Iterator[str]:
    for ticks in fates.tolist():
        # A time is rounded up to ticks when it is read, so it is rounded down here.
        picoseconds = floor(ticks / base_rate * 10**12)
        yield "lost" if ticks < 0 else f"{picoseconds // 10**12}.{picoseconds % 10**12:012d}"
