"""What a participant did, a line a step, on the disk before the next step begins."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, cast

from cosim.base.errors import InputError, RunError

Entry = dict[str, Any]


class StepLog:
    """A file of JSON lines that one process at a time appends to; a context manager."""

    def __init__(self, file: Path) -> None:
        """Open it, or make it, and read what is in it.

        A last line that was cut off is taken out: its step is done again.

        Raises:
            InputError: another process has it open, it cannot be written, or it is none.
        """
        self.file = file
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise InputError(f"{file}: cannot be written ({error.strerror}).") from error
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.entries = self._read()
        except BlockingIOError:
            os.close(self._descriptor)
            raise InputError(
                f"{file}: another session is writing it; end that one first."
            ) from None
        except InputError:
            os.close(self._descriptor)
            raise

    def append(self, entry: Entry) -> None:
        """Add a line; it is on the disk when this returns.

        Raises:
            RunError: it cannot be written.
        """
        line = json.dumps(entry, ensure_ascii=False).encode() + b"\n"
        try:
            os.lseek(self._descriptor, 0, os.SEEK_END)
            while line:
                line = line[os.write(self._descriptor, line) :]
            os.fsync(self._descriptor)
        except OSError as error:
            raise RunError(f"{self.file}: cannot be written ({error.strerror}).") from error
        self.entries.append(entry)

    def close(self) -> None:
        """Let others have it."""
        os.close(self._descriptor)

    def __enter__(self) -> StepLog:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self.close()

    def _read(self) -> list[Entry]:
        content = self.file.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            os.ftruncate(self._descriptor, len(whole))
        return parse_lines(self.file, whole)


def read_lines(file: Path) -> list[Entry]:
    """The whole lines of a log that may be in use.

    Raises:
        InputError: it cannot be read.
    """
    try:
        content = file.read_bytes()
    except FileNotFoundError:
        return []
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({error.strerror}).") from error
    return parse_lines(file, content[: content.rfind(b"\n") + 1])


def parse_lines(file: Path, content: bytes) -> list[Entry]:
    """Every line as the object that it is.

    Raises:
        InputError: a line is none.
    """
    found: list[Entry] = []
    for number, line in enumerate(content.splitlines(), 1):
        try:
            entry: Any = json.loads(line)
        except ValueError:
            entry = None
        if not isinstance(entry, dict):
            raise InputError(f"{file}:{number}: is no line of a study's log; put back the file.")
        found.append(cast("Entry", entry))
    return found
