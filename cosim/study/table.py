"""A study as one tidy table, a row a trial, ready for a mixed model; and its thresholds."""

from __future__ import annotations

from typing import Any

from cosim.study.folder import StudyFolder
from cosim.study.log import Entry, read_lines
from cosim.study.plan import StudyPlan
from cosim.study.questions import tlx_index
from cosim.study.session import noticed_in
from cosim.study.threshold import Threshold, estimate

Row = dict[str, Any]


def rows_of(folder: StudyFolder) -> list[Row]:
    """Every trial of everybody; answers to a condition's forms stand in each of its rows.

    ``excluded`` holds the reasons, where there are any: nothing is left out here.
    """
    return [row for code in folder.codes() for row in _of_person(folder, code)]


def columns_of(rows: list[Row]) -> dict[str, list[Any]]:
    """The same by column; ``None`` where a row has nothing."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return {name: [row.get(name) for row in rows] for name in names}


def thresholds(plan: StudyPlan, folder: StudyFolder) -> dict[str, dict[str, Threshold]]:
    """By condition: of each participant, and of all together as one (``all``)."""
    rule = plan.form.staircase
    if rule is None:
        return {}
    found: dict[str, dict[str, Threshold]] = {}
    for condition in plan.form.conditions:
        by_person = {
            code: noticed_in(kept, rule.answer)
            for code in folder.codes()
            if (kept := _kept(folder, code, condition))
        }
        everybody = [each for past in by_person.values() for each in past]
        if everybody:
            found[condition] = {
                name: estimate(past, rule.least, rule.most)
                for name, past in {**by_person, "all": everybody}.items()
            }
    return found


def _kept(folder: StudyFolder, code: str, condition: str) -> list[Entry]:
    return [
        entry
        for entry in read_lines(folder.of(code) / "log.jsonl")
        if entry.get("condition") == condition
        and "trial" in entry
        and not folder.excluded(code, entry["trial"])
    ]


def _of_person(folder: StudyFolder, code: str) -> list[Row]:
    entries = read_lines(folder.of(code) / "log.jsonl")
    if not entries:
        return []
    head = entries[0]
    forms = {entry["condition"]: entry["answers"] for entry in entries if "form" in entry}
    rows: list[Row] = []
    for entry in (each for each in entries if "trial" in each):
        workload = forms.get(entry["condition"], {})
        rows.append(
            {
                "participant": code,
                "number": head["number"],
                "emulated": head["emulated"],
                **{k: entry[k] for k in ("trial", "condition", "repetition", "value", "seed")},
                **entry["answers"],
                **workload,
                **({"tlx": tlx_index(workload)} if workload else {}),
                **entry["measures"],
                **{k: entry[k] for k in ("status", "shown_seconds", "answered_seconds", "started")},
                "run": f"people/{code}/{entry['run']}",
                "excluded": folder.excluded(code, entry["trial"]),
            }
        )
    return rows
