"""A study's plan, read and judged as a whole."""

from __future__ import annotations

import hashlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from cosim.base.document.form import read_form
from cosim.base.document.problems import Problems
from cosim.base.document.yaml_reader import read_yaml
from cosim.base.suggest import did_you_mean
from cosim.scenario.source.find import find_file
from cosim.study.form import ConditionForm, QuestionForm, StaircaseForm, StudyForm
from cosim.study.questions import NASA_TLX

OF_A_TRIAL = ("trial", "condition", "repetition", "value", "seed")
OF_ITS_END = ("status", "shown_seconds", "answered_seconds", "started")
"""What the log has of each trial, and the table too."""
COLUMNS = frozenset(
    {"participant", "number", "emulated", "run", "excluded", "tlx", *NASA_TLX}
    | {*OF_A_TRIAL, *OF_ITS_END}
)
"""Columns of the table; those of answers and measures come to them."""


@dataclass(frozen=True, slots=True)
class StudyPlan:
    """A plan whose parts fit each other."""

    file: Path
    form: StudyForm
    digest: str
    """SHA-256 of the file: a study goes on with the plan that it began with."""

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self.file.stem

    def scenario_of(self, condition: str) -> Path:
        """The file of a condition's scenario."""
        named = self.form.conditions[condition].scenario or self.form.scenario
        beside = self.file.parent / named
        return beside if beside.is_file() else find_file(named)


def read_study(file: Path, measures: Collection[str] = ()) -> StudyPlan:
    """A plan from its file; ``measures`` are those of its runs, which are columns of the table.

    Raises:
        InputError: everything that is wrong with it, each with its place.
    """
    root = read_yaml(file, str(file))
    form = read_form(StudyForm, root, "a study's plan")
    plan = StudyPlan(file, form, hashlib.sha256(file.read_bytes()).hexdigest())
    problems = Problems(root)
    for name, question in form.questions.items():
        if name in {*COLUMNS, *measures}:
            what = f"{name}: the table has a column of that name; choose another."
            problems.add(("questions", name), what, at_key=True)
        for sentence in _wrong_with(question):
            problems.add(("questions", name), f"questions.{name}: {sentence}", at_key=True)
    if form.staircase is not None:
        _judge_staircase(problems, form.staircase, form.questions)
    if form.emulated is not None:
        _judge_emulated(problems, form)
    for condition, written in form.conditions.items():
        own = ("conditions", condition, "scenario")
        with problems.at(own if written.scenario else ("scenario",)):
            plan.scenario_of(condition)
    problems.raise_if_any()
    return plan


def _wrong_with(question: QuestionForm) -> Iterator[str]:
    low, high, kind = question.least, question.most, question.kind
    if kind == "scale" and (low is None or high is None):
        yield "a scale has 'least' and 'most'."
    if kind not in {"scale", "number"} and not (low is None and high is None):
        yield "'least' and 'most' are of a scale or a number."
    if low is not None and high is not None and low >= high:
        yield "'least' is not below 'most'."
    if question.step is not None and low is None:
        yield "'step' is counted from 'least', which is not there."
    if kind == "choice" and (len(question.labels) < 2 or _has_twice(question.labels)):
        yield "a choice has two 'labels' or more, all different."
    if kind == "scale" and len(question.labels) not in {0, 2}:
        yield "a scale has two 'labels', what its ends mean, or none."
    if kind not in {"choice", "scale"} and question.labels:
        yield "'labels' are of a choice or a scale."


def _has_twice(labels: Sequence[str]) -> bool:
    """Also what nobody could type: answers are taken without the space around them."""
    return len({label.strip() for label in labels} - {""}) < len(labels)


def _judge_staircase(
    problems: Problems, rule: StaircaseForm, questions: Mapping[str, QuestionForm]
) -> None:
    if not rule.least <= rule.start <= rule.most or rule.least == rule.most:
        problems.add(
            ("staircase", "start"), "staircase: write least < most, and start between them."
        )
    asked = questions.get(rule.answer)
    if asked is None or asked.kind != "yes_no":
        hint = did_you_mean(rule.answer, [n for n, q in questions.items() if q.kind == "yes_no"])
        problems.add(
            ("staircase", "answer"),
            f"staircase: answer: '{rule.answer}' is no yes-or-no question.{hint}",
        )


def _judge_emulated(problems: Problems, form: StudyForm) -> None:
    assert form.emulated is not None
    given, known = set(form.emulated.threshold), set(form.conditions)
    if form.staircase is None:
        what = "emulated: it notices a staircase's value, and there is none."
        problems.add(("emulated",), what, at_key=True)
    if given != known:
        odd = ", ".join(sorted(given ^ known))
        what = f"emulated.threshold: name every condition and no other ({odd})."
        problems.add(("emulated", "threshold"), what, at_key=True)


def condition_sets(plan: StudyPlan, condition: str) -> list[str]:
    """What ``--set`` would be given for a condition."""
    chosen: ConditionForm = plan.form.conditions[condition]
    return [*plan.form.sets, *chosen.sets]
