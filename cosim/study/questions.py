"""Questions and what is an answer to them; the scales of NASA-TLX.

The workload index has six scales from 0 to 100 in steps of 5 (Hart and Staveland 1988); what is
kept is each scale and their mean, which is the index without weights (Hart 2006).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from cosim.study.form import QuestionForm

Answer = bool | float | str
Ask = Callable[[str, QuestionForm], Answer]
"""Puts a question, by its name, to somebody."""

TLX_STEP = 5.0


def _scale(ask: str, low: str, high: str) -> QuestionForm:
    ends = [low, high]
    return QuestionForm(ask=ask, kind="scale", least=0.0, most=100.0, step=TLX_STEP, labels=ends)


NASA_TLX: Mapping[str, QuestionForm] = {
    "tlx_mental": _scale("How much thinking did it take?", "very little", "very much"),
    "tlx_physical": _scale("How much bodily effort did it take?", "very little", "very much"),
    "tlx_temporal": _scale("How hurried did you feel?", "not at all", "very"),
    "tlx_performance": _scale("How well did you do what was asked?", "perfectly", "not at all"),
    "tlx_effort": _scale("How hard did you work for that?", "very little", "very hard"),
    "tlx_frustration": _scale("How annoyed or discouraged were you?", "not at all", "very"),
}


def parse_answer(question: QuestionForm, text: str) -> Answer:
    """What somebody typed as an answer.

    Raises:
        ValueError: it is none; the message says what would be.
    """
    given = text.strip()
    match question.kind:
        case "yes_no":
            if given.lower() in {"y", "yes"}:
                return True
            if given.lower() in {"n", "no"}:
                return False
            raise ValueError("Answer y or n.")
        case "choice":
            for label in question.labels:
                if label.strip() == given:
                    return label
            raise ValueError(f"Answer {', '.join(question.labels[:-1])} or {question.labels[-1]}.")
        case "text":
            return given
        case "scale" | "number":
            return _number(question, given)


def _number(question: QuestionForm, given: str) -> float:
    low = -math.inf if question.least is None else question.least
    high = math.inf if question.most is None else question.most
    limits = f" {limits}" if (limits := limits_of(question)) else ""
    whole = question.kind == "scale" and question.step is None
    kind = "a whole number" if whole else "a number"
    steps = "" if question.step is None else f" in steps of {question.step:g}"
    origin, step = (0.0, 1.0) if whole else (low, question.step)
    try:
        value = float(given)
    except ValueError:
        value = math.nan
    if not low <= value <= high or not _is_on_step(value, origin, step):
        raise ValueError(f"Answer {kind}{limits}{steps}.")
    return value


def limits_of(question: QuestionForm) -> str:
    """Between what its numbers lie, for people; empty where anything is one."""
    low, high = question.least, question.most
    if low is None:
        return "" if high is None else f"up to {high:g}"
    return f"from {low:g} on" if high is None else f"from {low:g} to {high:g}"


def _is_on_step(value: float, origin: float, step: float | None) -> bool:
    if step is None or not math.isfinite(value):
        return math.isfinite(value)
    steps = (value - origin) / step
    return math.isclose(steps, round(steps), abs_tol=1e-9)


def tlx_index(answers: Mapping[str, Answer]) -> float:
    """The mean of the six scales."""
    return sum(float(answers[name]) for name in NASA_TLX) / len(NASA_TLX)
