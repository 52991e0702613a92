"""How wide a text may be: as the terminal that shows it."""

from __future__ import annotations

import os
import sys


def shown_width() -> int | None:
    """Columns of the terminal; ``None`` where the text goes into a file or a pipe."""
    if not sys.stdout.isatty():
        return None
    # Not of shutil, which asks the descriptor that Python began with: FMUs may print there.
    return os.get_terminal_size(sys.stdout.fileno()).columns or None
