"""What every driver does about every fault: collected by the suite, kept in docs/safety.md."""

from __future__ import annotations

import os
from pathlib import Path

PAGE = Path(__file__).parents[3] / "docs" / "safety.md"
BEGIN, END = "<!-- fault table: written by the tests -->", "<!-- end of fault table -->"

Table = dict[tuple[str, str], str]
SEEN: Table = {}
"""(driver, fault) -> what happened; filled in by the tests as they pass."""


def render(table: Table) -> str:
    drivers = sorted({driver for driver, _ in table})
    faults = list(dict.fromkeys(fault for _, fault in sorted(table, key=_order(table))))
    lines = [
        "| fault | " + " | ".join(drivers) + " |",
        "|---" * (len(drivers) + 1) + "|",
        *(
            f"| {fault} | " + " | ".join(table.get((d, fault), "–") for d in drivers) + " |"
            for fault in faults
        ),
    ]
    return "\n".join(lines)


def _order(table: Table):
    seen = list(dict.fromkeys(fault for _, fault in table))
    return lambda key: seen.index(key[1])


def check(table: Table) -> None:
    """Compare with the page; COHAPTIC_WRITE_DOCS=1 writes it instead."""
    text = PAGE.read_text("utf-8")
    head, rest = text.split(BEGIN)
    old, tail = rest.split(END)
    new = f"\n\n{render(table)}\n\n"
    if os.environ.get("COHAPTIC_WRITE_DOCS") == "1":
        PAGE.write_text(head + BEGIN + new + END + tail, "utf-8")
        return
    assert old == new, "docs/safety.md is not what the suite saw; COHAPTIC_WRITE_DOCS=1 writes it"
