"""The results of a sweep in its folder, one line each, from which it is gone on with later.

``results.jsonl`` is written as results come, so that whatever ends the sweep, what was computed is
there. A last line that was cut off is not counted.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from types import TracebackType
from typing import Any

from cosim.base.errors import InputError, RunError
from cosim.base.system.writing import writing
from cosim.sweep.job import RunResult

RESULTS_FILE = "results.jsonl"
DESCRIPTION_FILE = "sweep.json"
FOLDER = Path("sweeps")
AGAIN = frozenset({"crashed"})
"""What is tried again when a sweep is gone on with."""


class ResultStore:
    """What came out so far, by key; a context manager that holds the file open."""

    def __init__(self, folder: Path) -> None:
        """Read what is in the folder already.

        Raises:
            InputError: the folder cannot be written, or holds something else.
        """
        self.folder = folder
        self.known: dict[str, RunResult] = {}
        self._file: int | None = None
        self._held: int | None = None
        try:
            _refuse_others(folder)
            folder.mkdir(parents=True, exist_ok=True)
            self._hold()
            self._read()
        except OSError as error:
            self.close()
            raise InputError(f"{folder} cannot be used: {error.strerror}.") from None
        except InputError:
            self.close()
            raise

    def describe(self, content: dict[str, Any]) -> None:
        """Write what the sweep is (``sweep.json``), whole or not at all.

        Raises:
            InputError: it cannot be written.
        """
        file = self.folder / DESCRIPTION_FILE
        scratch = file.with_name(f"{file.name}.{os.getpid()}")
        with writing(file):
            try:
                scratch.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
                scratch.replace(file)
            finally:
                scratch.unlink(missing_ok=True)

    def add(self, result: RunResult) -> None:
        """Keep one result.

        Raises:
            RunError: it cannot be written.
        """
        file = self.folder / RESULTS_FILE
        line = json.dumps(result.as_dict()).encode() + b"\n"
        try:
            if self._file is None:
                self._file = os.open(file, os.O_WRONLY | os.O_APPEND | os.O_CREAT, 0o666)
            while line:
                line = line[os.write(self._file, line) :]
        except OSError as error:
            raise RunError(
                f"{file} cannot be written: {error.strerror}. What came before is kept; the same "
                "command with this --out goes on."
            ) from None
        self.known[result.key] = result

    def close(self) -> None:
        """Close the file, and let others have the folder."""
        for descriptor in (self._file, self._held):
            if descriptor is not None:
                os.close(descriptor)
        self._file = self._held = None

    def __enter__(self) -> ResultStore:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def _hold(self) -> None:
        """Have the folder alone, where the system knows how.

        Raises:
            InputError: another sweep has it.
        """
        if sys.platform == "win32":
            return
        import fcntl

        self._held = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(self._held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(
                f"another sweep is at work in {self.folder}; wait for it, or name a new folder "
                "with --out."
            ) from None

    def _read(self) -> None:
        file = self.folder / RESULTS_FILE
        if not file.exists():
            return
        content = file.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if whole != content:
            with file.open("r+b") as cut:
                cut.truncate(len(whole))
        for number, line in enumerate(whole.splitlines(), 1):
            result = _result(line, f"{file}:{number}")
            if result.status not in AGAIN:
                self.known[result.key] = result


def _refuse_others(folder: Path) -> None:
    """Refuse a folder of something else.

    Raises:
        InputError: it is one, or no folder.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{folder} is a file, not a folder.")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / DESCRIPTION_FILE).exists():
        raise InputError(f"{folder} is not empty and holds no sweep; name a new folder with --out.")


def _result(line: bytes, place: str) -> RunResult:
    """A result from its line.

    Raises:
        InputError: it is none.
    """
    try:
        content: dict[str, Any] = json.loads(line)
        content["point"] = tuple(content["point"])
        return RunResult(**content)
    except (ValueError, TypeError, KeyError):
        raise InputError(
            f"{place}: this is no result as this version writes them; take the line out, or name a "
            "new folder with --out."
        ) from None


def next_folder(name: str) -> Path:
    """The next free ``sweeps/<name>-<n>``."""
    number = 1
    while (folder := FOLDER / f"{name}-{number}").exists():
        number += 1
    return folder
