"""A finished record made smaller without loss: gzip 1 behind a shuffle of bytes, read everywhere.

What compresses is a process of its own (this module with FROM and TO as arguments): HDF5 on a full
disk may end the process that it is in. The copy takes the record's place in one step, after it was
read again and found equal; until then nothing is changed.
"""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError, RunError
from cosim.record.digest import digest
from cosim.record.hdf5 import h5py
from cosim.record.layout import HDF5_VERSION
from cosim.record.reader import RUN_FILE, open_run
from cosim.record.signals import BLOCK_ROWS
from cosim.record.table import FLOATS, INTEGERS, TABLE

_LEVEL = 1
"""Of gzip; more takes longer and saves little behind the shuffle."""
_COPY = f"{RUN_FILE}.compressing"


@dataclass(frozen=True, slots=True)
class Compressed:
    """How large a record was and is (bytes)."""

    before: int
    after: int


def compress(folder: Path) -> Compressed | None:
    """Compress the record of a run that is over; ``None`` where it is compressed already.

    Raises:
        InputError: there is no run, it may still be going on, or it is of format 1.
        RunError: there is no room, or the copy was not equal; the record is as it was.
    """
    with open_run(folder) as run:
        folder = run.folder
        path, copy = folder / RUN_FILE, folder / _COPY
        if not all(group.rows == group.capacity for group in run.groups.values()):
            raise InputError(
                f"{path}: the run was killed or is still going on. If it was killed, 'cohaptic "
                "record compact' comes first."
            )
        if is_compressed(path):
            return None
        before = path.stat().st_size
        expected = digest(run)
    command = [sys.executable, "-m", "cosim.record.rewriting.compression", str(path), str(copy)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            said = done.stderr.strip().splitlines()
            why = said[-1] if said else f"its process ended with status {done.returncode}"
            raise RunError(f"{path} could not be compressed, and is as it was: {why}")
        with open_run(folder, file=copy) as again:
            if digest(again) != expected:
                raise RunError(f"{path} is as it was: what was compressed has another digest.")
        copy.replace(path)
    finally:
        copy.unlink(missing_ok=True)
    return Compressed(before, path.stat().st_size)


def is_compressed(path: Path) -> bool:
    """Whether the values of a ``run.h5`` are compressed."""
    with h5py().File(path, "r", locking=False) as file:
        return any(
            dataset in group and group[dataset].compression is not None
            for group in file.values()
            for dataset in (FLOATS, INTEGERS)
        )


def write_compressed(path: Path, copy: Path) -> None:
    """Write what is in ``path`` into a new file, compressed.

    Raises:
        OSError: it could not be written.
        ValueError: it is of format 1.
    """
    with (
        h5py().File(path, "r", locking=False, rdcc_nbytes=0) as source,
        h5py().File(copy, "w", libver=(HDF5_VERSION, HDF5_VERSION), rdcc_nbytes=0) as target,
    ):
        _describe(source, target)
        for name, group in source.items():
            if TABLE not in group:
                raise ValueError("it is of format 1, which is read and no longer written")
            there = target.create_group(name)
            _describe(group, there)
            for part in ("rows", TABLE):
                source.copy(group[part], there, name=part)
            for part in ("tick", FLOATS, INTEGERS):
                if part in group:
                    _pack(group[part], there, part)


def _pack(values: Any, group: Any, name: str) -> None:
    """A chunk for each signal and each block that readers take at once."""
    *signals, rows = values.shape
    if 0 in values.shape:
        group.create_dataset(name, data=values[()])
        return
    packed = group.create_dataset(
        name,
        shape=values.shape,
        dtype=values.dtype,
        chunks=(*([1] * len(signals)), min(rows, BLOCK_ROWS)),
        compression="gzip",
        compression_opts=_LEVEL,
        shuffle=True,
    )
    for signal in range(signals[0] if signals else 1):
        for first in range(0, rows, BLOCK_ROWS):
            place = slice(first, min(first + BLOCK_ROWS, rows))
            where = (signal, place) if signals else place
            packed[where] = values[where]


def _describe(source: Any, target: Any) -> None:
    for name, value in source.attrs.items():
        target.attrs[name] = value


if __name__ == "__main__":
    try:
        write_compressed(Path(sys.argv[1]), Path(sys.argv[2]))
    except (OSError, ValueError) as error:
        sys.exit(str(error))
