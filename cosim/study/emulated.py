"""A participant who is none: notices by chance, as a logistic function of the value says."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from cosim.study.form import EmulatedForm, QuestionForm
from cosim.study.questions import Answer
from cosim.study.session import StudyTrial


class EmulatedParticipant:
    """Answers what the plan's ``emulated`` says; other questions always in the same way."""

    def __init__(self, form: EmulatedForm, answer: str, seed: int) -> None:
        """``answer`` is the question that the staircase follows."""
        self._form, self._answer, self._seed = form, answer, seed

    def answers(
        self, questions: Mapping[str, QuestionForm], trial: StudyTrial | None
    ) -> dict[str, Answer]:
        """Drawn for the trial from its own seed: a session that goes on answers as a whole one."""
        return {name: self._answered(name, each, trial) for name, each in questions.items()}

    def _answered(self, name: str, question: QuestionForm, trial: StudyTrial | None) -> Answer:
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
                if question.most is None:
                    return low
                step = question.step or 1.0
                return low + (question.most - low) // 2 // step * step

    def rest(self, seconds: float) -> None:
        """Needs none."""
        del seconds
