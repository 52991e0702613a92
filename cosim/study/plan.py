"""A study's plan, read and judged as a whole."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from cosim.base.document.form import read_form
from cosim.base.document.yaml_reader import read_yaml
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.scenario.source.find import find_file
from cosim.study.form import ConditionForm, QuestionForm, StaircaseForm, StudyForm


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


def read_study(file: Path) -> StudyPlan:
    """A plan from its file.

    Raises:
        InputError: everything that is wrong with it, each with its place.
    """
    form = read_form(StudyForm, read_yaml(file, str(file)), "a study's plan")
    plan = StudyPlan(file, form, hashlib.sha256(file.read_bytes()).hexdigest())
    for name, question in form.questions.items():
        _judge_question(file, name, question)
    if form.staircase is not None:
        _judge_staircase(file, form.staircase, form.questions)
    if form.emulated is not None:
        _judge_emulated(file, form)
    for condition in form.conditions:
        plan.scenario_of(condition)
    return plan


def _judge_question(file: Path, name: str, question: QuestionForm) -> None:
    where = f"{file}: questions.{name}"
    ranged = question.least is not None or question.most is not None
    if question.kind == "scale" and (question.least is None or question.most is None):
        raise InputError(f"{where}: a scale has 'least' and 'most'.")
    if question.kind not in {"scale", "number"} and ranged:
        raise InputError(f"{where}: 'least' and 'most' are of a scale or a number.")
    if ranged and None not in (question.least, question.most):
        assert question.least is not None
        assert question.most is not None
        if question.least >= question.most:
            raise InputError(f"{where}: 'least' is not below 'most'.")
    if question.step is not None and question.least is None:
        raise InputError(f"{where}: 'step' is counted from 'least', which is not there.")
    if question.kind == "choice" and len(set(question.labels)) < 2:
        raise InputError(f"{where}: a choice has two 'labels' or more, all different.")
    if question.kind == "scale" and len(question.labels) not in {0, 2}:
        raise InputError(f"{where}: a scale has two 'labels', what its ends mean, or none.")
    if question.kind not in {"choice", "scale"} and question.labels:
        raise InputError(f"{where}: 'labels' are of a choice or a scale.")


def _judge_staircase(
    file: Path, rule: StaircaseForm, questions: Mapping[str, QuestionForm]
) -> None:
    where = f"{file}: staircase"
    if not rule.least <= rule.start <= rule.most or rule.least == rule.most:
        raise InputError(f"{where}: write least < most, and start between them.")
    asked = questions.get(rule.answer)
    if asked is None or asked.kind != "yes_no":
        hint = did_you_mean(rule.answer, [n for n, q in questions.items() if q.kind == "yes_no"])
        raise InputError(f"{where}: answer: '{rule.answer}' is no yes-or-no question.{hint}")


def _judge_emulated(file: Path, form: StudyForm) -> None:
    assert form.emulated is not None
    given, known = set(form.emulated.threshold), set(form.conditions)
    if form.staircase is None:
        raise InputError(f"{file}: emulated: it notices a staircase's value, and there is none.")
    if given != known:
        odd = ", ".join(sorted(given ^ known))
        raise InputError(f"{file}: emulated.threshold: name every condition and no other ({odd}).")


def condition_sets(plan: StudyPlan, condition: str) -> list[str]:
    """What ``--set`` would be given for a condition."""
    chosen: ConditionForm = plan.form.conditions[condition]
    return [*plan.form.sets, *chosen.sets]
