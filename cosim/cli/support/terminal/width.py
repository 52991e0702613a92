"""How wide a text may be: as the terminal that shows it."""

from __future__ import annotations

import os
import shutil
import sys


def shown_width() -> int | None:
    """Columns of the terminal (or of COLUMNS); ``None`` where the text goes into a file or pipe."""
    if not (sys.stdout.isatty() or os.environ.get("COLUMNS", "").isdecimal()):
        return None
    return shutil.get_terminal_size().columns
