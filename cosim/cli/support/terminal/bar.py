"""The bar of what takes long, on a terminal's standard error."""

from __future__ import annotations

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn


def progress_bar(name: str) -> Progress:
    """A bar that is gone when it ends; each task has a ``note``, and is drawn when it is told."""
    return Progress(
        TextColumn(name),
        BarColumn(),
        TextColumn("{task.fields[note]}"),
        console=Console(stderr=True),
        transient=True,
        auto_refresh=False,
    )
