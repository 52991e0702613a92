"""A participant at the terminal: questions until there is an answer, rest until Enter."""

from __future__ import annotations

import sys
import time
from collections.abc import Mapping

import click

from cosim.base.errors import InputError, RunError
from cosim.study.form import QuestionForm
from cosim.study.questions import Answer, limits_of, parse_answer
from cosim.study.session import LEFT, StudyTrial


class PersonAtTerminal:
    """Asks on standard error and reads the terminal."""

    def __init__(self) -> None:
        """Look for the terminal.

        Raises:
            InputError: there is none, so that nobody could answer.
        """
        if not sys.stdin.isatty():
            raise InputError(
                "questions need a terminal; --web asks on a page, --emulate tries a plan alone."
            )

    def answers(
        self, questions: Mapping[str, QuestionForm], trial: StudyTrial | None
    ) -> dict[str, Answer]:
        """Ask one after the other, each until what is typed is an answer.

        Raises:
            RunError: the participant ended the session.
        """
        del trial
        return {name: _answer(question) for name, question in questions.items()}

    def rest(self, seconds: float) -> None:
        """Wait, then for Enter."""
        click.echo(f"Rest{f' for {seconds:g} s' if seconds else ''}.", err=True)
        time.sleep(seconds)
        _line("Press Enter to go on: ")


def _answer(question: QuestionForm) -> Answer:
    while True:
        try:
            return parse_answer(question, _line(f"{question.ask} {_hint(question)}: "))
        except ValueError as error:
            click.echo(str(error), err=True)


def _line(prompt: str) -> str:
    """One line that is typed after the prompt, not before."""
    import termios

    click.echo(prompt, err=True, nl=False)
    termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)
    line = sys.stdin.readline()
    if not line:
        raise RunError(LEFT)
    return line


def _hint(question: QuestionForm) -> str:
    match question.kind:
        case "yes_no":
            return "(y/n)"
        case "choice":
            return f"({'/'.join(question.labels)})"
        case "text":
            return ""
        case "scale" | "number":
            ends = [f"{each:g}" for each in (question.least, question.most) if each is not None]
            if len(ends) < 2:
                return f"({limits})" if (limits := limits_of(question)) else ""
            low, high = question.labels or ("", "")
            return f"({ends[0]}{low and f' {low}'} … {ends[1]}{high and f' {high}'})"
