"""Room for memory that processes share: granted before it is mapped, or refused in a sentence.

A mapped file that is merely declared to be so long takes its pages when they are first touched.
Where none is left then, the process dies of SIGBUS in the midst of its work.
"""

from __future__ import annotations

import os
import shutil
import tempfile
from pathlib import Path
from typing import IO

from cosim.base.errors import RunError

SHARED = Path("/dev/shm")
"""Where files are in memory, on Linux."""
_ZEROS = bytes(1 << 16)


def shared_folder() -> Path:
    """Where files that processes share lie: in memory where the system has a place for that."""
    return SHARED if SHARED.is_dir() else Path(tempfile.gettempdir())


def new_shared_file(content: bytes, what: str, prefix: str) -> Path:
    """A file with that content in ``shared_folder``, every byte of it written.

    Raises:
        RunError: there is no room for it; ``what`` says for what.
    """
    folder = shared_folder()
    try:
        descriptor, name = tempfile.mkstemp(prefix=prefix, dir=folder)
        path = Path(name)
        try:
            with os.fdopen(descriptor, "wb") as file:
                file.write(content)
        except OSError:
            path.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise no_room(what, len(content), folder, error) from error
    return path


def nameless_shared_file(size: int, what: str) -> IO[bytes]:
    """An open file of ``size`` bytes without a name, for processes that are given it.

    Raises:
        RunError: there is no room for it; ``what`` says for what.
    """
    try:
        file = tempfile.TemporaryFile()  # noqa: SIM115 - whoever asked for it closes it
        try:
            _take(file, size)
        except OSError:
            file.close()
            raise
    except OSError as error:
        raise no_room(what, size, Path(tempfile.gettempdir()), error) from error
    return file


def no_room(what: str, size: int, folder: Path, error: OSError) -> RunError:
    """The sentence of a refusal of the system."""
    remedy = "free some, or name another folder in TMPDIR"
    if folder == SHARED:
        remedy = (
            "free some ('cohaptic doctor' removes what killed runs have left), or give it more "
            "(mount -o remount,size=1G /dev/shm; docker run --shm-size 1g)"
        )
    return RunError(
        f"There is no room for {what} in {folder}: it takes {in_words(size)}, and "
        f"{in_words(_free(folder))} are free ({error.strerror or error}); {remedy}."
    )


def in_words(count: int) -> str:
    """A number of bytes in decimal units, as disks are sold."""
    value, unit = float(count), "bytes"
    for larger in ("kB", "MB", "GB", "TB", "PB"):
        if value < 1000:
            break
        value, unit = value / 1000, larger
    return f"{value:.3g} {unit}"


def _take(file: IO[bytes], size: int) -> None:
    """Make an empty file so long, with all of its pages."""
    if hasattr(os, "posix_fallocate"):
        os.posix_fallocate(file.fileno(), 0, size)
        return
    for begin in range(0, size, len(_ZEROS)):
        file.write(_ZEROS[: size - begin])
    file.flush()


def _free(folder: Path) -> int:
    try:
        return shutil.disk_usage(folder).free
    except OSError:
        return 0
