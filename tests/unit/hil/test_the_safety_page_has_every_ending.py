"""The table of endings in docs/safety.md is the one that the suite holds the product to."""

from __future__ import annotations

import os
from pathlib import Path

from tests.support.hil.ending_table import ANSWER, ENDINGS

PAGE = Path(__file__).parents[3] / "docs" / "safety.md"
BEGIN, END = "<!-- endings: written by the tests -->", "<!-- end of endings -->"


def rendered() -> str:
    lines = [
        "| ending | zero on the wire within | confirmed within | the command |",
        "|---|---|---|---|",
    ]
    for name, ending in ENDINGS.items():
        says = "ends with status 1" if ending.alive else "is gone"
        confirmed = (ending.within + ANSWER) * 1e3
        lines.append(f"| {name} | {ending.within * 1e3:.0f} ms | {confirmed:.0f} ms | {says} |")
    return "\n".join(lines)


def test_the_page_has_every_ending():
    text = PAGE.read_text("utf-8")
    head, rest = text.split(BEGIN)
    old, tail = rest.split(END)
    new = f"\n\n{rendered()}\n\n"
    if os.environ.get("COHAPTIC_WRITE_DOCS") == "1":
        PAGE.write_text(head + BEGIN + new + END + tail, "utf-8")
        return
    assert old == new, "COHAPTIC_WRITE_DOCS=1 writes docs/safety.md"
