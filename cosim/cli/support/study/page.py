"""A participant at the page: sheets of questions in a browser, rest until a button is pressed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from cosim.base.errors import RunError
from cosim.study.form import QuestionForm
from cosim.study.questions import Answer, parse_answer
from cosim.study.session import LEFT, StudyTrial

if TYPE_CHECKING:
    from cosim.live.process import ServerProcess


class PersonAtPage:
    """Asks on the page of a server, which shows the trials too."""

    def __init__(self, server: ServerProcess, say: Callable[[str], None]) -> None:
        self._server, self._say = server, say
        self._number = 0

    def announce(self, text: str) -> None:
        """Say what comes now, above the scene; the first time, wait until somebody is there.

        Raises:
            RunError: they leave, or the server is gone.
        """
        if self._number == 0:
            self._ask({"heading": "Welcome.", "button": "Begin"})
        self._say(text)
        self._show({"heading": text})

    def answers(
        self, questions: Mapping[str, QuestionForm], trial: StudyTrial | None
    ) -> dict[str, Answer]:
        """All of them on one sheet, which comes again until every text is an answer.

        Raises:
            RunError: the participant left, or the server is gone.
        """
        heading = "About the trials until now" if trial is None else f"After trial {trial.number}"
        given: dict[str, str] = {}
        problems: dict[str, str] = {}
        while True:
            asked = [
                {
                    **question.model_dump(),
                    "name": name,
                    "given": given.get(name, ""),
                    "problem": problems.get(name, ""),
                }
                for name, question in questions.items()
            ]
            given = self._ask({"heading": heading, "questions": asked, "button": "Go on"})
            found, problems = _judged(questions, given)
            if not problems:
                return found

    def rest(self, seconds: float) -> None:
        """The button opens when the break has been long enough.

        Raises:
            RunError: as :meth:`answers`.
        """
        self._ask({"heading": "Rest as long as you like.", "button": "Go on", "wait": seconds})

    def _show(self, sheet: Mapping[str, Any]) -> None:
        self._number += 1
        self._server.tell({"number": self._number, **sheet})

    def _ask(self, sheet: Mapping[str, Any]) -> dict[str, str]:
        """What is answered to a sheet with a button."""
        self._show(sheet)
        said = self._server.hear()
        if "leave" in said:
            raise RunError(LEFT)
        return said["answers"]


def _judged(
    questions: Mapping[str, QuestionForm], given: Mapping[str, str]
) -> tuple[dict[str, Answer], dict[str, str]]:
    """Answers, and what is wrong with the others."""
    found: dict[str, Answer] = {}
    problems: dict[str, str] = {}
    for name, question in questions.items():
        try:
            found[name] = parse_answer(question, given.get(name, ""))
        except ValueError as error:
            problems[name] = str(error)
    return found, problems
