"""The table of endings in docs/safety.md is the one that the suite holds the product to."""

from __future__ import annotations

from pathlib import Path

from tests.support.guide.written import hold_between
from tests.support.hil.ending_table import ANSWER, BESIDE_WORK, ENDINGS

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
    hold_between(PAGE, BEGIN, END, rendered())


def test_the_page_has_what_holds_beside_other_work():
    (ending,) = BESIDE_WORK.values()
    page = " ".join(PAGE.read_text("utf-8").split())
    zero, confirmed = (
        f"{seconds * 1e3:.0f} ms" for seconds in (ending.within, ending.within + ANSWER)
    )
    assert (
        f"a killed loop's motors are at zero within {zero}, confirmed within {confirmed}," in page
    )
