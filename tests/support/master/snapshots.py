"""Runs that are saved on the way, and continued in a process of their own."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path

import numpy as np

from cosim.analysis import load_tuned
from cosim.base.recording import RecordGroup, Rows
from cosim.master.run.simulation import Simulation, assemble
from cosim.master.run.snapshot import read_snapshot
from cosim.record.playback import KINDS


class LateSink:
    """A sink of which only the rows from some tick on are asked for."""

    def begin(self, groups: Sequence[RecordGroup], base_rate: Fraction) -> None:
        self.groups = groups
        self._blocks: list[list[tuple[int, Rows]]] = [[] for _ in groups]

    def buffer(self, group: int, rows: int) -> Rows:
        self._open = np.zeros((rows, len(self.groups[group].columns)), dtype=np.int64)
        self._blocks[group].append((-1, self._open))
        return self._open

    def commit(self, group: int, first_tick: int, rows: int) -> None:
        self._blocks[group][-1] = (first_tick, self._blocks[group][-1][1][:rows])

    def digest(self, tick: int) -> str:
        """SHA-256 (hex) of every row of ``tick`` and later."""
        state = hashlib.sha256()
        for group, blocks in zip(self.groups, self._blocks, strict=True):
            state.update(f"{group.name} {[column.name for column in group.columns]}".encode())
            numbers = [first + group.period * np.arange(len(rows)) for first, rows in blocks]
            ticks = np.concatenate(numbers)
            late = ticks >= tick
            state.update(ticks[late].tobytes())
            state.update(np.concatenate([rows for _, rows in blocks])[late].tobytes())
        return state.hexdigest()


def simulation_of(path: Path, sets: Sequence[str]) -> Simulation:
    return assemble(load_tuned(path, (), list(sets)), None, KINDS)


def whole(path: Path, sets: Sequence[str], until: int) -> LateSink:
    """A run without interruption."""
    sink = LateSink()
    with simulation_of(path, sets) as simulation:
        simulation.run(sink, until=until)
    return sink


def save(
    path: Path, sets: Sequence[str], ticks: Sequence[int], until: int, folder: Path
) -> list[Path]:
    """Run once to ``until`` and leave a file for each tick."""
    files = [folder / f"snapshot-{tick}" for tick in ticks]
    with simulation_of(path, sets) as simulation:
        simulation.run(
            LateSink(),
            until=until,
            pauses={
                tick: lambda file=file: simulation.snapshot().write(file)
                for tick, file in zip(ticks, files, strict=True)
            },
        )
    return files


def continued(path: Path, sets: Sequence[str], files: Sequence[Path], until: int) -> list[str]:
    """The digests of what follows each snapshot, from another process."""
    job = {"path": str(path), "sets": list(sets), "files": list(map(str, files)), "until": until}
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.master.snapshots"],
        input=json.dumps(job),
        capture_output=True,
        text=True,
        check=False,
        cwd=Path(__file__).parents[3],
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def _main() -> None:
    job = json.load(sys.stdin)
    found: list[str] = []
    for file in job["files"]:
        snapshot = read_snapshot(Path(file))
        sink = LateSink()
        with simulation_of(Path(job["path"]), job["sets"]) as simulation:
            simulation.restore(snapshot)
            simulation.run(sink, until=job["until"])
        found.append(sink.digest(snapshot.tick))
    print(json.dumps(found))


if __name__ == "__main__":
    _main()
