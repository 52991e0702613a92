"""The index of the decisions names every page with its title, a date and a status, and no other."""

from __future__ import annotations

import re
from datetime import date
from pathlib import Path

FOLDER = Path(__file__).parents[3] / "docs" / "decisions"
ROW = re.compile(r"\| \[(\d{3})\]\(([\w.-]+)\) (.+) \| (\S+) \| (.+) \|")
STATUS = re.compile(r"in force|replaced by \[\d{3}\]\([\w.-]+\)")


def test_the_index_is_the_folder() -> None:
    text = (FOLDER / "README.md").read_text(encoding="utf-8")
    rows = [match.groups() for line in text.splitlines() if (match := ROW.fullmatch(line))]
    assert len(rows) == text.count("\n| [")
    there = sorted(file for file in FOLDER.glob("*.md") if file.name != "README.md")
    assert [name for _, name, *_ in rows] == [file.name for file in there]
    for (number, name, title, day, status), file in zip(rows, there, strict=True):
        assert name.startswith(f"{number}-")
        heading = file.read_text(encoding="utf-8").partition("\n")[0]
        assert heading in {f"# {number}: {title}", f"# {number} {title}", f"# {title}"}
        assert date.fromisoformat(day) <= date.today()  # noqa: DTZ011
        assert STATUS.fullmatch(status)
