"""What was left out by mistake counts again, and both decisions stay: who, when and why."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.study.folder import EXCLUSIONS_FILE, StudyFolder, now
from cosim.study.log import StepLog, read_lines

TRIALS = (1, 2, 3)
DECISIONS = st.lists(st.tuples(st.booleans(), st.sampled_from([None, *TRIALS])), max_size=8)


def study(path: Path) -> StudyFolder:
    """A participant ``a`` who has done three trials."""
    folder = StudyFolder(path)
    folder.path.mkdir()
    folder.number_of("a", emulated=False)
    with StepLog(folder.of("a") / "log.jsonl") as log:
        for trial in TRIALS:
            log.append({"trial": trial})
    return folder


@given(decisions=DECISIONS)
def test_the_last_decision_about_a_trial_counts(
    tmp_path_factory: pytest.TempPathFactory, decisions: list[tuple[bool, int | None]]
) -> None:
    folder = study(tmp_path_factory.mktemp("study") / "a")
    is_out = dict.fromkeys(TRIALS, False)
    for is_excluded, trial in decisions:
        meant = TRIALS if trial is None else (trial,)
        if is_excluded:
            folder.exclude("a", trial, "slept", "Ada")
        elif any(is_out[each] for each in meant):
            folder.include("a", trial, "was awake", "Bo")
        else:
            with pytest.raises(InputError, match="nothing to take back"):
                folder.include("a", trial, "was awake", "Bo")
            continue
        is_out |= dict.fromkeys(meant, is_excluded)
    assert {trial: bool(folder.excluded("a", trial)) for trial in TRIALS} == is_out


def test_both_decisions_stay_with_who_and_when_and_why(tmp_path: Path) -> None:
    folder = study(tmp_path / "study")
    folder.exclude("a", 2, "took the hand away", "Ada")
    folder.include("a", 2, "it was trial 3", "Bo")
    folder.exclude("a", 3, "took the hand away", "Bo")
    assert [folder.excluded("a", trial) for trial in TRIALS] == ["", "", "took the hand away"]
    entries = read_lines(folder.path / EXCLUSIONS_FILE)
    told = [(each["trial"], each["excluded"], each["reason"], each["by"]) for each in entries]
    assert told == [
        (2, True, "took the hand away", "Ada"),
        (2, False, "it was trial 3", "Bo"),
        (3, True, "took the hand away", "Bo"),
    ]
    assert all(each["when"] <= now() for each in entries)


def test_a_reason_that_was_taken_back_is_none_of_a_later_exclusion(tmp_path: Path) -> None:
    folder = study(tmp_path / "study")
    folder.exclude("a", None, "left early", "Ada")
    folder.include("a", None, "came back", "Ada")
    folder.exclude("a", 1, "slept", "Ada")
    folder.exclude("a", 1, "and dreamt", "Ada")
    assert folder.excluded("a", 1) == "slept; and dreamt"
    assert folder.excluded("a", 2) == ""


def test_an_entry_of_before_there_was_a_way_back_is_an_exclusion(tmp_path: Path) -> None:
    folder = study(tmp_path / "study")
    with StepLog(folder.path / EXCLUSIONS_FILE) as log:
        log.append({"code": "a", "trial": 1, "reason": "slept", "when": now()})
    assert folder.excluded("a", 1) == "slept"
    folder.include("a", 1, "was awake", "Ada")
    assert folder.excluded("a", 1) == ""


def test_who_is_unknown_is_said(tmp_path: Path) -> None:
    folder = study(tmp_path / "study")
    with pytest.raises(InputError, match="nobody called 'A' takes part"):
        folder.include("A", None, "came back", "Ada")
    with pytest.raises(InputError, match="a has no trial 4"):
        folder.include("a", 4, "came back", "Ada")
    with pytest.raises(InputError, match="a, trial 1, is not excluded"):
        folder.include("a", 1, "came back", "Ada")
    with pytest.raises(InputError, match="no trial of a is excluded"):
        folder.include("a", None, "came back", "Ada")
