"""A study's sheet: the first page answers, what is late, early or odd is dropped."""

from __future__ import annotations

import time
from typing import Any

import pytest

from cosim.live.study.sheets import Sheets

ASKED = {"number": 3, "heading": "After trial 1", "questions": [{"name": "a"}], "button": "Go on"}


@pytest.fixture(name="table")
def _table() -> tuple[Sheets, list[Any]]:
    heard: list[Any] = []
    return Sheets("A title", heard.append), heard


def test_the_first_answer_counts_and_takes_the_sheet_away(table):
    sheets, heard = table
    sheets.show(ASKED)
    assert sheets.told() == {"type": "sheet", "title": "A title", **ASKED, "wait": 0.0}
    assert sheets.hear({"sheet": {"number": 3, "answers": {"a": "y"}}})
    assert not sheets.hear({"sheet": {"number": 3, "answers": {"a": "n"}}})
    assert not sheets.hear({"sheet": {"number": 3, "leave": True}})
    assert heard == [{"number": 3, "answers": {"a": "y"}}]
    assert "button" not in sheets.told()
    assert "questions" not in sheets.told()


@pytest.mark.parametrize(
    "said",
    [
        *(None, [], "y", {}, {"number": 2, "answers": {"a": "y"}}, {"answers": {"a": "y"}}),
        *({"number": 3}, {"number": 3, "answers": ["y"]}, {"number": 3, "answers": {"a": 1}}),
        {"number": 3, "leave": "yes"},
    ],
)
def test_what_is_no_answer_to_it_is_dropped(table, said):
    sheets, heard = table
    sheets.show(ASKED)
    assert not sheets.hear({"sheet": said})
    assert heard == []
    assert sheets.told()["button"] == "Go on"


def test_nothing_is_taken_where_nothing_is_asked(table):
    sheets, heard = table
    for _ in range(2):
        assert not sheets.hear({"sheet": {"number": 0, "answers": {}}})
        assert not sheets.hear({"sheet": {"number": 0, "leave": True}})
        sheets.show({"number": 0, "heading": "Trial 1 of 2."})
    assert heard == []
    assert sheets.told()["heading"] == "Trial 1 of 2."


def test_a_break_is_not_cut_short_but_may_be_left(table):
    sheets, heard = table
    sheets.show({"number": 1, "heading": "Rest", "button": "Go on", "wait": 0.05})
    assert not sheets.hear({"sheet": {"number": 1, "answers": {}}})
    assert 0 < sheets.told()["wait"] <= 0.05
    time.sleep(0.06)
    assert sheets.told()["wait"] == 0.0
    assert sheets.hear({"sheet": {"number": 1, "answers": {}}})
    sheets.show({"number": 2, "heading": "Rest", "button": "Go on", "wait": 60})
    assert sheets.hear({"sheet": {"number": 2, "leave": True}})
    assert heard == [{"number": 1, "answers": {}}, {"number": 2, "leave": True}]
