"""What is typed is an answer or is refused with what would be one."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.study.form import QuestionForm
from cosim.study.questions import NASA_TLX, limits_of, parse_answer, tlx_index


@pytest.mark.parametrize(
    ("typed", "answer"), [("y", True), (" YES ", True), ("n\n", False), ("No", False)]
)
def test_yes_and_no(typed: str, answer: bool) -> None:
    assert parse_answer(QuestionForm(ask="?"), typed) is answer


def test_a_choice_is_one_of_its_labels() -> None:
    asked = QuestionForm(ask="?", kind="choice", labels=["left hand", " right "])
    assert parse_answer(asked, " left hand\n") == "left hand"
    assert parse_answer(asked, "right") == " right "
    with pytest.raises(ValueError, match="left hand or"):
        parse_answer(asked, "both")


@pytest.mark.parametrize(
    ("limits", "words"),
    [
        ({}, ""),
        ({"least": 0}, "from 0 on"),
        ({"most": 2.5}, "up to 2.5"),
        ({"least": -1, "most": 1}, "from -1 to 1"),
    ],
)
def test_a_refused_number_is_told_its_limits(limits: dict[str, float], words: str) -> None:
    asked = QuestionForm(ask="?", kind="number", **limits)
    assert limits_of(asked) == words
    with pytest.raises(ValueError, match=f"a number {words}".strip()):
        parse_answer(asked, "many")


@given(
    value=st.floats(-10, 110),
    least=st.integers(-3, 3),
    steps=st.integers(1, 50),
    step=st.floats(0.1, 5),
)
def test_a_scale_takes_its_steps_and_nothing_between(
    value: float, least: int, steps: int, step: float
) -> None:
    asked = QuestionForm(ask="?", kind="scale", least=least, most=least + steps * step, step=step)
    on_step = least + min(max(round((value - least) / step), 0), steps) * step
    assert parse_answer(asked, repr(on_step)) == on_step
    with pytest.raises(ValueError, match="in steps of"):
        parse_answer(asked, repr(on_step + 0.4 * step))


@given(st.text())
def test_whatever_is_typed_is_finite_or_refused(typed: str) -> None:
    try:
        found = parse_answer(QuestionForm(ask="?", kind="number"), typed)
    except ValueError:
        return
    assert math.isfinite(float(found))


def test_the_workload_is_the_mean_of_six_scales() -> None:
    answers = {
        name: float(value) for name, value in zip(NASA_TLX, (0, 5, 95, 100, 30, 10), strict=True)
    }
    assert tlx_index(answers) == 40.0
    for asked in NASA_TLX.values():
        assert [parse_answer(asked, text) for text in ("0", "100", "35")] == [0, 100, 35]
        for wrong in ("", "33", "-5", "105", "nan"):
            with pytest.raises(ValueError, match="from 0 to 100 in steps of 5"):
                parse_answer(asked, wrong)
