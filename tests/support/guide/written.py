"""What the tests write into a page: between two marks, compared, or with an order written."""

from __future__ import annotations

import os
from pathlib import Path


def between(page: Path, begin: str, end: str) -> str:
    """What stands between the marks."""
    return page.read_text("utf-8").split(begin)[1].split(end)[0]


def write_between(page: Path, begin: str, end: str, body: str) -> None:
    """Put ``body``, with an empty line around it, between the marks."""
    head, rest = page.read_text("utf-8").split(begin)
    _, tail = rest.split(end)
    page.write_text(f"{head}{begin}\n\n{body}\n\n{end}{tail}", "utf-8")


def hold_between(page: Path, begin: str, end: str, body: str) -> None:
    """Compare with what stands there; COHAPTIC_WRITE_DOCS=1 writes it instead.

    Raises:
        AssertionError: the page says something else.
    """
    if os.environ.get("COHAPTIC_WRITE_DOCS") == "1":
        write_between(page, begin, end, body)
        return
    assert between(page, begin, end) == f"\n\n{body}\n\n", (
        f"COHAPTIC_WRITE_DOCS=1 writes docs/{page.name}"
    )
