"""What a plan says is what happens: order, rest, forms, values, seeds; nothing is run here."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from cosim.study.folder import StudyFolder
from cosim.study.form import QuestionForm, StudyForm
from cosim.study.plan import condition_sets, read_study
from cosim.study.questions import Answer
from cosim.study.session import StudyTrial, take_part

PLAN: dict[str, Any] = {
    "study": 1,
    "title": "A title",
    "scenario": "single_axis_distributed",
    "set": ["duration=1"],
    "seed": 3,
    "conditions": {"one": {}, "two": {"set": ["duration=2"]}, "three": {}, "four": {}},
    "trials": 2,
    "staircase": {
        "vary": "lan.round_trip_delay",
        "unit": "ms",
        "least": 0,
        "most": 9,
        "start": 5,
        "steps": [2, 1],
        "down": 2,
        "up": 1,
        "answer": "felt",
    },
    "questions": {"felt": {"ask": "Felt?"}},
    "after_condition": ["nasa_tlx"],
    "break": {"every": 2, "least": 7},
}
OTHERWISE = {
    "title": "Another",
    "seed": 4,
    "set": ["duration=3"],
    "scenario": "single_axis_centralized",
    "conditions": {**PLAN["conditions"], "two": {"scenario": "single_axis_centralized"}},
    "trials": 3,
    "order": "interleaved",
    "staircase": {**PLAN["staircase"], "start": 4},
    "questions": {"felt": {"ask": "Noticed?"}},
    "after_condition": [],
    "break": {"every": 3, "least": 7},
}
ELSEWHERE = {
    "study": "the version: test_a_log_keeps_whole_steps",
    "emulated": "tests/system/study",
}


class Somebody:
    def __init__(self, *, notices: bool) -> None:
        self.did: list[Any] = []
        self._notices = notices

    def answers(
        self, questions: Mapping[str, QuestionForm], trial: StudyTrial | None
    ) -> dict[str, Answer]:
        self.did += [(name, each.ask, trial) for name, each in questions.items()]
        return {n: self._notices if q.kind == "yes_no" else 50.0 for n, q in questions.items()}

    def rest(self, seconds: float) -> None:
        self.did.append(seconds)


def happens(content: dict[str, Any], folder: Path, *, notices: bool = True) -> Any:
    folder.mkdir()
    file = folder / "plan.yaml"
    file.write_text(json.dumps(content))
    plan, study = read_study(file), StudyFolder(folder / "study")
    somebody = Somebody(notices=notices)

    def run(trial: StudyTrial, _: Path) -> dict[str, Any]:
        somebody.did.append((trial, condition_sets(plan, trial.condition)))
        somebody.did.append(plan.scenario_of(trial.condition))
        return {"status": 0, "message": "", "measures": {}}

    take_part(plan, study, "P1", somebody, run, emulated=False, say=lambda _: None)
    return somebody.did, json.loads((study.path / "study.json").read_text())["title"]


def test_every_key_has_a_case() -> None:
    keys = {field.alias or name for name, field in StudyForm.model_fields.items()}
    assert keys == set(OTHERWISE) | set(ELSEWHERE)


@pytest.mark.parametrize("key", OTHERWISE)
def test_a_key_changes_what_happens(key: str, tmp_path: Path) -> None:
    once, again = (happens(PLAN, tmp_path / name) for name in ("once", "again"))
    assert once == again
    assert happens({**PLAN, key: OTHERWISE[key]}, tmp_path / "other") != once


@pytest.mark.parametrize(
    ("key", "value", "notices"),
    [
        *(("start", 6, True), ("least", 4, True), ("steps", [1], True), ("down", 1, True)),
        *(("most", 6, False), ("up", 2, False), ("start", 4, False)),
    ],
)
def test_a_key_of_the_staircase_changes_the_values(
    key: str, value: Any, notices: bool, tmp_path: Path
) -> None:
    plan = {**PLAN, "trials": 6}
    usual = happens(plan, tmp_path / "usual", notices=notices)
    stairs = {**PLAN["staircase"], key: value}
    other = happens({**plan, "staircase": stairs}, tmp_path / "other", notices=notices)
    assert other != usual


def test_a_break_lasts_as_long_as_it_says(tmp_path: Path) -> None:
    did, _ = happens(PLAN, tmp_path / "rest")
    assert [each for each in did if isinstance(each, float)] == [7.0, 7.0, 7.0]
