"""A step is kept whole or not at all, by one session at a time."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.study.folder import StudyFolder
from cosim.study.log import StepLog, read_lines
from cosim.study.plan import read_study


@given(
    cut=st.integers(0, 200), entries=st.lists(st.dictionaries(st.text(max_size=5), st.integers()))
)
def test_cut_anywhere_it_has_the_steps_before(
    tmp_path_factory: pytest.TempPathFactory, cut: int, entries: list[dict[str, int]]
) -> None:
    file = tmp_path_factory.mktemp("log") / "log.jsonl"
    with StepLog(file) as log:
        for entry in entries:
            log.append(entry)
    content = file.read_bytes()
    file.write_bytes(content[: max(0, len(content) - cut)])
    kept = read_lines(file)
    assert kept == entries[: len(kept)]
    with StepLog(file) as log:
        assert log.entries == kept
        log.append({"next": 1})
    assert [json.loads(line) for line in file.read_bytes().splitlines()] == [*kept, {"next": 1}]


def test_one_session_at_a_time(tmp_path: Path) -> None:
    with StepLog(tmp_path / "log.jsonl"), pytest.raises(InputError, match="another session"):
        StepLog(tmp_path / "log.jsonl")


def test_a_line_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.jsonl").write_text('{"a": 1}\nspoiled\n')
    with pytest.raises(InputError, match=r"log\.jsonl:2"):
        StepLog(tmp_path / "log.jsonl")


STAIRCASE = "{{vary: v, least: 0, most: 1, start: {start}, steps: {steps}, answer: a}}"
PLAN = """\
study: 1
scenario: single_axis_distributed
conditions: {one: {}, two: {}}
trials: 2
"""


def test_a_study_keeps_its_plan_and_an_exclusion_its_reason(tmp_path: Path) -> None:
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    folder = StudyFolder(tmp_path / "study")
    folder.begin(read_study(plan))
    numbers = [folder.number_of(code, emulated=False) for code in ("a", "b", "a")]
    assert numbers == [0, 1, 0]
    with pytest.raises(InputError, match="nobody called 'c'"):
        folder.exclude("c", None, "left", "Ada")
    with pytest.raises(InputError, match="has a reason"):
        folder.exclude("a", None, " ", "Ada")
    with pytest.raises(InputError, match="--by"):
        folder.exclude("a", None, "left", " ")
    with pytest.raises(InputError, match="no trial 3"):
        folder.exclude("a", 3, "slept", "Ada")
    folder.exclude("a", None, "slept", "Ada")
    assert folder.excluded("a", 7) == "slept"
    assert folder.excluded("b", 7) == ""
    plan.write_text(PLAN + "seed: 4\n")
    with pytest.raises(InputError, match="keeps its plan"):
        folder.begin(read_study(plan))


@pytest.mark.parametrize(
    "left", [[], ["plan.yaml"], ["plan.yaml", "study.json.part"], ["study.json.part"]]
)
def test_a_study_that_was_cut_off_before_it_began_is_begun(left: list[str], tmp_path: Path) -> None:
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    folder = StudyFolder(tmp_path / "study")
    folder.path.mkdir()
    for name in left:
        (folder.path / name).write_text("half")
    folder.begin(read_study(plan))
    folder.begin(read_study(plan))
    assert (folder.path / "plan.yaml").read_text() == PLAN
    assert {each.name for each in folder.path.iterdir()} == {"plan.yaml", "study.json"}


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    plan = tmp_path / "plan.yaml"
    plan.write_text(PLAN)
    (tmp_path / "other").write_text("")
    with pytest.raises(InputError, match="holds no study"):
        StudyFolder(tmp_path).begin(read_study(plan))
    folder = StudyFolder(tmp_path / "study")
    folder.begin(read_study(plan))
    for text in ("", "[]", "{}"):
        (folder.path / "study.json").write_text(text)
        with pytest.raises(InputError, match="put it back"):
            folder.begin(read_study(plan))


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ("questions: {a: {ask: x, kind: scale}}", "a scale has"),
        ("questions: {condition: {ask: x}}", "has a column of that name"),
        ("questions: {tlx_effort: {ask: x}}", "has a column of that name"),
        ("questions: {drift: {ask: x}}", "has a column of that name"),
        ("questions: {a: {ask: x, least: 1}}", "of a scale or a number"),
        ("questions: {a: {ask: x, kind: number, least: 2, most: 1}}", "not below"),
        ("questions: {a: {ask: x, kind: choice, labels: [b]}}", "two 'labels' or more"),
        ("questions: {a: {ask: x, labels: [b, c]}}", "of a choice or a scale"),
        (
            f"staircase: {STAIRCASE.format(start=2, steps='[1]')}",
            "start between",
        ),
        (
            f"staircase: {STAIRCASE.format(start=1, steps='[1]')}",
            "no yes-or-no",
        ),
        (f"staircase: {STAIRCASE.format(start=1, steps='[]')}", "steps"),
        ("emulated: {threshold: {one: 1}, slope: 1}", "there is none"),
        ("trial: 3", "trials"),
    ],
)
def test_a_plan_whose_parts_do_not_fit_is_refused(more: str, said: str, tmp_path: Path) -> None:
    plan = tmp_path / "plan.yaml"
    plan.write_text(f"{PLAN}{more}\n")
    with pytest.raises(InputError, match=said) as caught:
        read_study(plan, ["drift"])
    assert re.match(r".*plan\.yaml:[5-9]:\d+: ", str(caught.value))
