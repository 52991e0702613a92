"""One participant through a study: trials, questions and rest, kept step by step.

A session may end anywhere and go on later: what a step gave is on the disk before the next begins,
and a trial without all its answers is done again.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np

from cosim.base.errors import InputError, RunError
from cosim.study.folder import StudyFolder, now
from cosim.study.form import QuestionForm
from cosim.study.log import Entry, StepLog
from cosim.study.order import blocked, interleaved
from cosim.study.plan import StudyPlan
from cosim.study.questions import NASA_TLX, Answer
from cosim.study.staircase import next_value


@dataclass(frozen=True, slots=True)
class StudyTrial:
    """What is about to be shown."""

    number: int
    """From 1."""
    condition: str
    repetition: int
    """Which trial of its condition, from 1."""
    value: float | None
    """The staircase's."""
    seed: int
    """For the scenario."""


class Respondent(Protocol):
    """Who sits there: a person at a terminal, or one who is emulated."""

    def answers(
        self, questions: Mapping[str, QuestionForm], trial: StudyTrial | None
    ) -> dict[str, Answer]:
        """What is answered, by the questions' names; ``trial`` is the one that was just shown."""
        ...

    def rest(self, seconds: float) -> None:
        """A break of at least so long."""
        ...


LEFT = "\nThe session is left; the same command goes on where it was."

RunTrial = Callable[[StudyTrial, Path], Mapping[str, Any]]
"""Runs a trial into a folder; the content of its summary."""


@dataclass(frozen=True, slots=True)
class _Step:
    kind: Literal["trial", "form", "rest"]
    trial: int
    condition: str


def take_part(
    plan: StudyPlan,
    folder: StudyFolder,
    code: str,
    participant: Respondent,
    run_trial: RunTrial,
    *,
    emulated: bool,
    say: Callable[[str], None],
) -> int:
    """Go through the study, or go on with it; how many trials are done in the end.

    Raises:
        InputError: the folder is of another plan, or the participant is at work elsewhere.
        RunError: a trial's run did not come to its end, or somebody leaves; that step is done again
            the next time.
    """
    folder.begin(plan)
    number = folder.number_of(code, emulated=emulated)
    place = folder.of(code)
    with StepLog(place / "log.jsonl") as log:
        if not log.entries:
            order = _order(plan, number)
            log.append({"order": order, "number": number, "emulated": emulated, "began": now()})
        head, done = log.entries[0], log.entries[1:]
        if head["emulated"] != emulated:
            who = "emulated" if head["emulated"] else "a person"
            raise InputError(f"{code} is {who} until now; use another code.")
        steps = list(_steps(plan, head["order"]))
        if done:
            say(f"{code} goes on after {len(_trials(done))} of {len(head['order'])} trials.")
        session = _Session(plan, place, log, participant, run_trial)
        for step in steps[len(done) :]:
            try:
                log.append(session.do(step))
            except KeyboardInterrupt:
                raise RunError(LEFT) from None
        return len(_trials(log.entries[1:]))


def _order(plan: StudyPlan, number: int) -> list[str]:
    names, trials = list(plan.form.conditions), plan.form.trials
    if plan.form.order == "blocked":
        return blocked(names, trials, number)
    return interleaved(names, trials, number, plan.form.seed)


def _steps(plan: StudyPlan, order: list[str]) -> Iterator[_Step]:
    """Everything that is done, in order."""
    rest = plan.form.rest
    for place, condition in enumerate(order):
        number = place + 1
        yield _Step("trial", number, condition)
        if condition not in order[number:] and plan.form.after_condition:
            yield _Step("form", number, condition)
        if rest is not None and number % rest.every == 0 and number < len(order):
            yield _Step("rest", number, condition)


@dataclass(frozen=True, slots=True)
class _Session:
    """One sitting of one participant."""

    plan: StudyPlan
    place: Path
    log: StepLog
    participant: Respondent
    run_trial: RunTrial

    def do(self, step: _Step) -> Entry:
        """What a step gave."""
        match step.kind:
            case "rest":
                return self._rest(step)
            case "form":
                answers = self.participant.answers(NASA_TLX, None)
                head = {"form": "nasa_tlx", "condition": step.condition}
                return {**head, "answers": answers, "at": now()}
            case "trial":
                return self._show(self._trial(step))

    def _rest(self, step: _Step) -> Entry:
        assert self.plan.form.rest is not None
        began = time.monotonic()
        self.participant.rest(self.plan.form.rest.least)
        return {"rest": step.trial, "seconds": time.monotonic() - began}

    def _trial(self, step: _Step) -> StudyTrial:
        head, past = self.log.entries[0], _trials(self.log.entries[1:])
        same = [entry for entry in past if entry["condition"] == step.condition]
        rule = self.plan.form.staircase
        value = None if rule is None else next_value(rule, noticed_in(same, rule.answer))
        origin = [self.plan.form.seed, int(head["number"]), step.trial]
        drawn = np.random.Generator(np.random.PCG64(origin)).integers(2**31)
        return StudyTrial(step.trial, step.condition, len(same) + 1, value, int(drawn))

    def _show(self, trial: StudyTrial) -> Entry:
        folder = _free(self.place / f"trial-{trial.number:03d}")
        started, began = now(), time.monotonic()
        content = self.run_trial(trial, folder)
        if content["message"]:
            raise RunError(
                f"trial {trial.number} did not come to its end: {content['message']}\n"
                "What was done before is kept; the same command does this trial again."
            )
        shown = time.monotonic() - began
        asked = self.plan.form.questions
        answers = self.participant.answers(asked, trial) if asked else {}
        return {
            "trial": trial.number,
            "condition": trial.condition,
            "repetition": trial.repetition,
            "value": trial.value,
            "seed": trial.seed,
            "run": folder.name,
            "status": content["status"],
            "measures": content["measures"],
            "answers": answers,
            "started": started,
            "shown_seconds": shown,
            "answered_seconds": time.monotonic() - began - shown,
        }


def noticed_in(trials: list[Entry], answer: str) -> list[tuple[float, bool]]:
    """Value and answer of trials, for staircases and thresholds."""
    return [(float(entry["value"]), bool(entry["answers"][answer])) for entry in trials]


def _trials(entries: list[Entry]) -> list[Entry]:
    return [entry for entry in entries if "trial" in entry]


def _free(folder: Path) -> Path:
    """The folder of a trial; one that was cut off before stays, under another name."""
    if folder.exists():
        number = 1
        while (old := folder.with_name(f"{folder.name}-cut-{number}")).exists():
            number += 1
        folder.rename(old)
    return folder
