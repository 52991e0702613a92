"""The table of replies in docs/safety.md is the one that the suite holds the product to."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from tests.support.guide.written import hold_between
from tests.support.hil.reply_table import LOST, TABLE, Said

PAGE = Path(__file__).parents[3] / "docs" / "safety.md"
BEGIN, END = "<!-- replies: written by the tests -->", "<!-- end of replies -->"


def outcome(said: Said) -> str:
    if said.why:
        return f"nothing: {said.why}"
    return "no sample: its age counts" if said.words == LOST else "FAULT"


def rendered() -> str:
    lines = ["| board | field | says | then |", "|---|---|---|---|"]
    for (board, field), group in groupby(TABLE, lambda said: (said.board, said.field)):
        odd = list(group)
        says = "; ".join(
            said.value + (" (inactive)" if said.inactive and "inactive" not in said.value else "")
            for said in odd
        )
        then = "; ".join(dict.fromkeys(map(outcome, odd)))
        lines.append(f"| {board} | {field} | {says} | {then} |")
    return "\n".join(lines)


def test_the_page_has_every_reply():
    hold_between(PAGE, BEGIN, END, rendered())
