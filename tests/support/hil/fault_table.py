"""What every driver does about every fault, as the suite sees it, kept in docs/safety.md."""

from __future__ import annotations

import os
from pathlib import Path

from tests.support.guide.written import between, write_between

PAGE = Path(__file__).parents[3] / "docs" / "safety.md"
BEGIN, END = "<!-- fault table: written by the tests -->", "<!-- end of fault table -->"

Table = dict[str, dict[str, str]]
"""fault -> driver -> what happened, in the order of the page."""


def read() -> Table:
    """The table as it stands on the page."""
    lines = between(PAGE, BEGIN, END).strip().splitlines()
    (_, *drivers), _, *rows = ([c.strip() for c in line.strip("|").split("|")] for line in lines)
    return {fault: dict(zip(drivers, cells, strict=True)) for fault, *cells in rows}


def note(driver: str, fault: str, happened: str) -> None:
    """Compare with the page's cell; COHAPTIC_WRITE_DOCS=1 writes it instead, in one process."""
    table = read()
    if os.environ.get("COHAPTIC_WRITE_DOCS") == "1":
        table.setdefault(fault, {})[driver] = happened
        _write(table)
        return
    assert table.get(fault, {}).get(driver) == happened, (
        f"docs/safety.md does not say of {driver}, {fault}: {happened}; COHAPTIC_WRITE_DOCS=1 "
        "writes it"
    )


def _write(table: Table) -> None:
    drivers = sorted({driver for row in table.values() for driver in row})
    lines = [
        "| fault | " + " | ".join(drivers) + " |",
        "|---" * (len(drivers) + 1) + "|",
        *(
            f"| {fault} | " + " | ".join(row.get(driver, "–") for driver in drivers) + " |"
            for fault, row in table.items()
        ),
    ]
    write_between(PAGE, BEGIN, END, "\n".join(lines))
