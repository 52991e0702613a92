"""Files that a user asked for, where they cannot be written: a sentence, and status 2."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from cosim.base.errors import InputError


@contextmanager
def writing(path: Path, hint: str = "choose another place") -> Generator[None]:
    """Say of whatever the system refuses inside that ``path`` cannot be written.

    Raises:
        InputError: with the system's reason and ``hint``.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        if isinstance(error, FileNotFoundError):
            reason = f"there is no folder {path.parent}"
        raise InputError(f"{path} cannot be written: {reason}; {hint}.") from error
