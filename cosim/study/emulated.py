"""A participant who is none: notices by chance, as a logistic function of the value says."""

from __future__ import annotations

import math

import numpy as np

from cosim.study.form import EmulatedForm, QuestionForm
from cosim.study.questions import Answer
from cosim.study.session import StudyTrial


class EmulatedParticipant:
    """Answers what the plan's ``emulated`` says; other questions always in the same way."""

    def __init__(self, form: EmulatedForm, answer: str, seed: int) -> None:
        """``answer`` is the question that the staircase follows."""
        self._form, self._answer, self._seed = form, answer, seed

    def answer(self, name: str, question: QuestionForm, trial: StudyTrial | None) -> Answer:
        """Drawn for the trial from its own seed: a session that goes on answers as a whole one."""
        if name == self._answer and trial is not None and trial.value is not None:
            steep = self._form.slope * (trial.value - self._form.threshold[trial.condition])
            share = 1 / (1 + math.exp(-min(max(steep, -500.0), 500.0)))
            generator = np.random.Generator(np.random.PCG64([self._seed, trial.seed]))
            return bool(generator.random() < share)
        match question.kind:
            case "yes_no":
                return False
            case "choice":
                return question.labels[0]
            case "text":
                return ""
            case "scale" | "number":
                low = question.least if question.least is not None else 0.0
                return low if question.most is None else (low + question.most) // 2

    def rest(self, seconds: float) -> None:
        """Needs none."""
        del seconds
