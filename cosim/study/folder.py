"""The folder of a study: its plan, who takes part, who is left out of it, by whom and why."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.base.system.writing import writing
from cosim.study.log import Entry, StepLog, read_lines
from cosim.study.plan import StudyPlan

STUDY_FILE, PEOPLE_FILE, EXCLUSIONS_FILE = "study.json", "people.jsonl", "exclusions.jsonl"
PLAN_FILE, STUDY_PART = "plan.yaml", "study.json.part"
BEGUN = frozenset({PLAN_FILE, STUDY_PART})
"""What is there of a study that was cut off before it began."""
CODE = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,31}")


@dataclass(frozen=True, slots=True)
class StudyFolder:
    """Where a study is kept."""

    path: Path

    def begin(self, plan: StudyPlan) -> None:
        """Make the folder for a plan, or go on with it.

        Raises:
            InputError: it belongs to another plan, or cannot be written.
        """
        file = self.path / STUDY_FILE
        if file.is_file():
            if _plan_of(file) != plan.digest:
                raise InputError(
                    f"{plan.file} is not the plan that the study in {self.path} began with; a "
                    "study keeps its plan. Put it back, or begin another study with --out."
                )
            return
        if self.path.is_dir() and any(each.name not in BEGUN for each in self.path.iterdir()):
            raise InputError(f"{self.path} is not empty and holds no study; choose another folder.")
        with writing(file):
            self.path.mkdir(parents=True, exist_ok=True)
            (self.path / PLAN_FILE).write_bytes(plan.file.read_bytes())
            about = {"study": 1, "title": plan.form.title, "plan_sha256": plan.digest}
            part = self.path / STUDY_PART
            part.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
            part.replace(file)  # the last thing: a folder without it is begun again

    def number_of(self, code: str, *, emulated: bool) -> int:
        """Which participant this is, from 0; the next free number the first time.

        Those who are emulated are counted apart: no place of an order is spent on nobody.

        Raises:
            InputError: it is no code, or another session is writing.
        """
        if not CODE.fullmatch(code):
            raise InputError(f"'{code}' is no code: letters, digits, - and _, at most 32 of them.")
        with StepLog(self.path / PEOPLE_FILE) as people:
            for entry in people.entries:
                if entry["code"] == code:
                    return int(entry["number"])
            number = sum(entry.get("emulated", False) is emulated for entry in people.entries)
            entry = {"code": code, "number": number, "emulated": emulated, "since": now()}
            people.append(entry)
            return number

    def codes(self) -> list[str]:
        """Who takes part, in the order of their numbers."""
        return [str(entry["code"]) for entry in read_lines(self.path / PEOPLE_FILE)]

    def of(self, code: str) -> Path:
        """A participant's folder."""
        return self.path / "people" / code

    def exclude(self, code: str, trial: int | None, reason: str, by: str) -> None:
        """Leave a participant, or one trial, out of what is computed; nothing is deleted.

        ``by`` is who decides it.

        Raises:
            InputError: there is none, or no reason.
        """
        self._trials(code, trial)
        self._decide(code, trial, reason, by, is_excluded=True)

    def include(self, code: str, trial: int | None, reason: str, by: str) -> None:
        """Take back that a participant, or one trial, is left out: both entries stay.

        Raises:
            InputError: there is none, it is not left out, or no reason.
        """
        if not any(self.excluded(code, each) for each in self._trials(code, trial)):
            what = f"no trial of {code} is" if trial is None else f"{code}, trial {trial}, is not"
            raise InputError(f"{what} excluded: there is nothing to take back.")
        self._decide(code, trial, reason, by, is_excluded=False)

    def excluded(self, code: str, trial: int) -> str:
        """Why a trial is left out, since it was last taken back; empty where it is not."""
        reasons: list[str] = []
        for entry in read_lines(self.path / EXCLUSIONS_FILE):
            if entry["code"] == code and entry["trial"] in {None, trial}:
                if entry.get("excluded", True):
                    reasons.append(str(entry["reason"]))
                else:
                    reasons.clear()
        return "; ".join(reasons)

    def _trials(self, code: str, trial: int | None) -> list[int]:
        """The trials of a participant that were done, or the one that is asked for."""
        if code not in self.codes():
            known = did_you_mean(code, self.codes())
            raise InputError(f"nobody called '{code}' takes part in {self.path}.{known}")
        entries = read_lines(self.of(code) / "log.jsonl")
        trials = [int(each["trial"]) for each in entries if "trial" in each]
        if trial is not None and trial not in trials:
            raise InputError(f"{code} has no trial {trial}.")
        return trials if trial is None else [trial]

    def _decide(
        self, code: str, trial: int | None, reason: str, by: str, *, is_excluded: bool
    ) -> None:
        if not reason.strip():
            raise InputError("what is left out, or taken back, has a reason.")
        if not by.strip():
            raise InputError("somebody decides it: name them with --by.")
        with StepLog(self.path / EXCLUSIONS_FILE) as decisions:
            about: Entry = {"code": code, "trial": trial, "excluded": is_excluded}
            decisions.append({**about, "reason": reason.strip(), "by": by.strip(), "when": now()})


def _plan_of(file: Path) -> str:
    """The SHA-256 of the plan that a study began with.

    Raises:
        InputError: the file is none of a study.
    """
    try:
        return str(json.loads(file.read_text(encoding="utf-8"))["plan_sha256"])
    except (OSError, ValueError, TypeError, KeyError):
        raise InputError(f"{file} cannot be read as that of a study; put it back.") from None


def now() -> str:
    """The time, for people."""
    return datetime.now(UTC).isoformat(timespec="seconds")
