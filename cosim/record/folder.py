"""Where a run goes: ``runs/<scenario>-<n>`` unless told, and never over something else."""

from __future__ import annotations

import re
from pathlib import Path

from cosim.base.errors import InputError

RUNS = Path("runs")


def new_folder(scenario: str, out: Path | None = None) -> Path:
    """Create the folder of a new run.

    ``out`` may exist if it is empty. Without it the folder is the first free
    ``runs/<scenario>-<n>`` after the highest n there is, below the working directory.

    Raises:
        InputError: ``out`` is a file or not empty, or the folder cannot be created.
    """
    try:
        return _numbered(scenario) if out is None else _given(out)
    except OSError as error:
        place = error.filename or out or RUNS
        raise InputError(
            f"{place}: the run's folder cannot be created ({error.strerror}). "
            "Choose another with --out."
        ) from error


def check_folder(out: Path | None) -> None:
    """Refuse a folder that a run cannot go into; nothing is created.

    Raises:
        InputError: ``out`` is a file or not empty.
    """
    if out is None:
        return
    if out.exists() and not out.is_dir():
        raise InputError(f"{out}: is a file; --out takes a folder for the run.")
    if out.is_dir() and any(out.iterdir()):
        raise InputError(
            f"{out}: is not empty, and a run is never written over another. "
            "Choose a new folder with --out, or remove this one."
        )


def _given(out: Path) -> Path:
    check_folder(out)
    out.mkdir(parents=True, exist_ok=True)
    return out


def _numbered(scenario: str) -> Path:
    RUNS.mkdir(exist_ok=True)
    pattern = re.compile(re.escape(scenario) + r"-(\d+)")
    taken = [int(match[1]) for path in RUNS.iterdir() if (match := pattern.fullmatch(path.name))]
    number = max(taken, default=0) + 1
    while True:
        folder = RUNS / f"{scenario}-{number}"
        try:
            folder.mkdir()
        except FileExistsError:  # another process was faster
            number += 1
        else:
            return folder
