"""Cut off before, in or after any step, a session goes on as if it had never been."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import RunError
from cosim.study.folder import StudyFolder
from cosim.study.form import QuestionForm
from cosim.study.log import read_lines
from cosim.study.plan import StudyPlan, read_study
from cosim.study.questions import NASA_TLX, Answer
from cosim.study.session import StudyTrial, take_part
from cosim.study.table import columns_of, rows_of, thresholds

PLAN: dict[str, Any] = {
    "study": 1,
    "scenario": "single_axis_distributed",
    "seed": 3,
    "conditions": {"one": {}, "two": {}},
    "trials": 3,
    "staircase": {
        "vary": "lan.round_trip_delay",
        "least": 0,
        "most": 1,
        "start": 0.5,
        "steps": [0.1],
        "down": 1,
        "answer": "felt",
    },
    "questions": {"felt": {"ask": "Felt?"}, "comfort": {"ask": "?", "kind": "number"}},
    "after_condition": ["nasa_tlx"],
    "break": {"every": 2},
}
TIMES = {"began", "at", "seconds", "started", "shown_seconds", "answered_seconds"}
STEPS = 6 + 2 + 2
"""Trials, forms and breaks of a whole session."""


class KilledError(BaseException):
    """The process is gone: nothing that follows is done."""


class Somebody:
    """Answers from what is shown, and is cut off at its ``last`` call (from 1), if there is one."""

    def __init__(self, last: int | None = None, cut: type[BaseException] = KilledError) -> None:
        self.calls, self._last, self._cut = 0, last, cut
        self.seen: list[StudyTrial] = []

    def call(self) -> None:
        self.calls += 1
        if self.calls == self._last:
            raise self._cut

    def answers(
        self, questions: Mapping[str, QuestionForm], trial: StudyTrial | None
    ) -> dict[str, Answer]:
        self.call()
        if trial is None:
            return {name: 10.0 * number for number, name in enumerate(NASA_TLX)}
        assert trial.value is not None
        return {"felt": trial.value > 0.35, "comfort": float(trial.number)}

    def rest(self, seconds: float) -> None:
        del seconds
        self.call()

    def run(self, trial: StudyTrial, folder: Path) -> dict[str, Any]:
        folder.mkdir(parents=True)
        self.call()
        self.seen.append(trial)
        return {"status": 0, "message": "", "measures": {"drift": trial.value}}


@pytest.fixture(name="plan")
def _plan(tmp_path: Path) -> StudyPlan:
    file = tmp_path / "plan.yaml"
    file.write_text(json.dumps(PLAN))
    return read_study(file)


def sit(
    plan: StudyPlan, folder: StudyFolder, somebody: Somebody, code: str = "P1", **kinds: bool
) -> int:
    emulated = kinds.get("emulated", False)
    return take_part(
        plan, folder, code, somebody, somebody.run, emulated=emulated, say=lambda _: None
    )


def logged(folder: StudyFolder, code: str = "P1") -> list[dict[str, Any]]:
    entries = read_lines(folder.of(code) / "log.jsonl")
    return [{k: v for k, v in entry.items() if k not in TIMES} for entry in entries]


def whole(plan: StudyPlan, folder: StudyFolder) -> tuple[list[dict[str, Any]], int]:
    somebody = Somebody()
    assert sit(plan, folder, somebody) == 6
    return logged(folder), somebody.calls


def test_a_session_has_all_its_steps(plan: StudyPlan, tmp_path: Path) -> None:
    entries, calls = whole(plan, StudyFolder(tmp_path / "whole"))
    assert len(entries) == 1 + STEPS
    assert calls == STEPS + 6, "a trial is shown and asked about"
    assert [entry["rest"] for entry in entries if "rest" in entry] == [2, 4]


def test_killed_at_any_call_it_has_the_same_log_in_the_end(plan: StudyPlan, tmp_path: Path) -> None:
    expected, calls = whole(plan, StudyFolder(tmp_path / "whole"))
    for last in range(1, calls + 1):
        folder = StudyFolder(tmp_path / str(last))
        with pytest.raises(KilledError):
            sit(plan, folder, Somebody(last))
        assert logged(folder) == expected[: len(logged(folder))]
        assert sit(plan, folder, Somebody()) == 6
        assert logged(folder) == expected
        runs = {entry["run"] for entry in expected if "run" in entry}
        assert runs <= {each.name for each in folder.of("P1").iterdir()}


def test_killed_again_and_again_it_comes_to_its_end(plan: StudyPlan, tmp_path: Path) -> None:
    expected, _ = whole(plan, StudyFolder(tmp_path / "whole"))
    folder = StudyFolder(tmp_path / "often")
    for _ in range(3 * STEPS):
        try:
            sit(plan, folder, Somebody(3))
        except KilledError:
            continue
        break
    assert logged(folder) == expected


def test_a_log_cut_at_any_byte_goes_on(plan: StudyPlan, tmp_path: Path) -> None:
    """What a power cut may leave of the last step."""
    whole_folder = StudyFolder(tmp_path / "whole")
    expected, _ = whole(plan, whole_folder)
    content = (whole_folder.of("P1") / "log.jsonl").read_bytes()
    lines = content.splitlines(keepends=True)
    ends = [sum(map(len, lines[: number + 1])) for number in range(len(lines))]
    for end in {*ends, *(each - 1 for each in ends), 0, 10}:
        folder = StudyFolder(tmp_path / f"cut-{end}")
        shutil.copytree(whole_folder.path, folder.path)
        (folder.of("P1") / "log.jsonl").write_bytes(content[:end])
        assert sit(plan, folder, Somebody()) == 6
        assert logged(folder) == expected


def test_whoever_interrupts_is_told_how_to_go_on(plan: StudyPlan, tmp_path: Path) -> None:
    _, calls = whole(plan, StudyFolder(tmp_path / "whole"))
    for last in range(1, calls + 1):
        folder = StudyFolder(tmp_path / str(last))
        with pytest.raises(RunError, match="the same command goes on"):
            sit(plan, folder, Somebody(last, KeyboardInterrupt))


def test_values_are_those_that_somebody_would_write(plan: StudyPlan, tmp_path: Path) -> None:
    somebody = Somebody()
    sit(plan, StudyFolder(tmp_path / "study"), somebody)
    values = {trial.value for trial in somebody.seen}
    assert values == {0.5, 0.4, 0.3}, "0.5 - 0.1 - 0.1 is 0.30000000000000004"


def test_a_row_is_a_trial_with_all_that_belongs_to_it(plan: StudyPlan, tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path / "study")
    sit(plan, folder, Somebody())
    folder.exclude("P1", 5, "slept", "Ada")
    rows = rows_of(folder)
    assert [row["trial"] for row in rows] == [1, 2, 3, 4, 5, 6]
    assert [row["condition"] for row in rows] == ["one"] * 3 + ["two"] * 3
    assert [row["repetition"] for row in rows] == [1, 2, 3] * 2
    assert [row["value"] for row in rows] == [0.5, 0.4, 0.3] * 2
    assert [row["felt"] for row in rows] == [True, True, False] * 2
    assert [row["drift"] for row in rows] == [row["value"] for row in rows]
    assert [row["excluded"] for row in rows] == ["", "", "", "", "slept", ""]
    assert {row["tlx"] for row in rows} == {25.0}
    assert [rows[0][name] for name in NASA_TLX] == [0.0, 10.0, 20.0, 30.0, 40.0, 50.0]
    assert all((folder.path / row["run"]).is_dir() for row in rows)
    columns = columns_of(rows)
    assert {len(column) for column in columns.values()} == {6}


def test_a_condition_has_its_workload_when_it_is_over(plan: StudyPlan, tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path / "study")
    with pytest.raises(KilledError):
        sit(plan, folder, Somebody(12))
    columns = columns_of(rows_of(folder))
    assert columns["tlx"] == [25.0] * 3 + [None] * (len(columns["tlx"]) - 3)
    assert len(columns["tlx"]) > 3


def test_nobody_takes_the_place_or_the_answers_of_a_person(plan: StudyPlan, tmp_path: Path) -> None:
    folder = StudyFolder(tmp_path / "study")
    sit(plan, folder, Somebody(), "E1", emulated=True)
    assert set(thresholds(plan, folder)["one"]) == {"E1", "all"}
    sit(plan, folder, Somebody(), "P1")
    sit(plan, folder, Somebody(), "P2")
    assert set(thresholds(plan, folder)["one"]) == {"P1", "P2", "all"}
    assert thresholds(plan, folder)["one"]["all"].trials == 6
    orders = {code: logged(folder, code)[0]["order"] for code in ("E1", "P1", "P2")}
    assert orders["E1"] == orders["P1"] == orders["P2"][::-1]
    assert {row["participant"] for row in rows_of(folder)} == {"E1", "P1", "P2"}
