"""What a study asks on its page: one sheet at a time, answered once, by whichever page is first.

The study's process writes a sheet, the server shows it on every page, and what the first page
answers goes back. Answers are judged where the study is: here they are texts.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from typing import Any, cast

LARGEST_ANSWER = 2**20
"""Of a page that answers (bytes)."""


class Sheets:
    """The sheet that is shown now, and whether it still waits for an answer."""

    def __init__(self, title: str, pass_on: Callable[[Mapping[str, Any]], None]) -> None:
        """``title`` stands on the page in place of the scenario's name, which may tell too much."""
        self._title, self._pass_on = title, pass_on
        self._sheet: dict[str, Any] = {"number": 0}
        self._answered = True
        self._opens = 0.0

    def show(self, sheet: Mapping[str, Any]) -> None:
        """Put this sheet in the place of the one before; ``wait`` (s) is how long it stays shut."""
        self._sheet = dict(sheet)
        self._answered = "button" not in sheet
        self._opens = time.monotonic() + float(sheet.get("wait", 0.0))

    def told(self) -> dict[str, Any]:
        """For a page."""
        wait = max(0.0, self._opens - time.monotonic())
        shown = {"number": self._sheet["number"]} if self._answered else self._sheet
        about = {"heading": self._sheet.get("heading", "")}
        return {"type": "sheet", "title": self._title, **about, **shown, "wait": round(wait, 3)}

    def hear(self, message: Mapping[str, Any]) -> bool:
        """Take what a page says to the sheet; whether that changes what the others see."""
        said = message.get("sheet")
        if not isinstance(said, dict):
            return False
        given = cast("dict[str, Any]", said)
        if self._answered or given.get("number") != self._sheet["number"]:
            return False
        if given.get("leave") is True:
            answer: dict[str, Any] = {"leave": True}
        elif time.monotonic() < self._opens or not _are_texts(given.get("answers")):
            return False
        else:
            answer = {"answers": given["answers"]}
        self._answered = True
        self._pass_on({"number": self._sheet["number"], **answer})
        return True


def _are_texts(answers: Any) -> bool:
    if not isinstance(answers, dict):
        return False
    return all(isinstance(each, str) for each in cast("dict[str, Any]", answers).values())
