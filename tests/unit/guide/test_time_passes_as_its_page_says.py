"""docs/time.md: its table is what a run gives, and what its sentences say, computed apart."""

from __future__ import annotations

from pathlib import Path

from tests.support.guide.time_page import PAGE, ROWS, rows

PERIOD = 8


def table() -> list[tuple[int, ...]]:
    lines = ROWS.findall(PAGE.read_text(encoding="utf-8"))[0][1].splitlines()
    return [tuple(int(cell) for cell in line.strip("|").split("|")) for line in lines]


def held(tick: int, samples: int) -> tuple[int, int, int]:
    """Value, age and number, from the page's sentences: P · (⌊k / P⌋ − n), before it that of 0."""
    number = tick // PERIOD - samples
    return (number * PERIOD, tick - number * PERIOD, number) if number >= 0 else (0, tick, -1)


def test_the_table_is_what_a_run_gives(tmp_path: Path) -> None:
    assert table() == rows(tmp_path)


def test_the_table_is_what_the_sentences_say() -> None:
    said = table()
    assert [row[0] for row in said] == list(range(3 * PERIOD + 1))
    for tick, source, none, one, age, number, two in said:
        assert source == tick
        assert none == held(tick, 0)[0]
        assert (one, age, number) == held(tick, 1)
        assert two == held(tick, 2)[0]
