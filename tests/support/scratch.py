"""Folders that helpers keep as long as their process lives, and that go with it."""

from __future__ import annotations

import atexit
import os
import shutil
import tempfile
from pathlib import Path


def scratch_folder(kind: str) -> Path:
    """A new folder ``cohaptic-<kind>-…``; processes that were forked from this one leave it."""
    folder, owner = Path(tempfile.mkdtemp(prefix=f"cohaptic-{kind}-")), os.getpid()

    def remove() -> None:
        if os.getpid() == owner:
            shutil.rmtree(folder, ignore_errors=True)

    atexit.register(remove)
    return folder
