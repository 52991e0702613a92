"""A study as one tidy table, a row a trial, ready for a mixed model; and its thresholds."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosim.study.folder import StudyFolder
from cosim.study.log import Entry, read_lines
from cosim.study.plan import OF_A_TRIAL, OF_ITS_END, StudyPlan
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


def units_of(plan: StudyPlan, measures: Mapping[str, str]) -> dict[str, str]:
    """The units of columns that have one; ``measures`` are those of the runs' measures."""
    units = dict.fromkeys(("shown_seconds", "answered_seconds"), "s")
    units |= {name: unit for name, unit in measures.items() if unit}
    if plan.form.staircase is not None and plan.form.staircase.unit:
        units["value"] = plan.form.staircase.unit
    return units


def thresholds(plan: StudyPlan, folder: StudyFolder) -> dict[str, dict[str, Threshold]]:
    """By condition: of each participant, and of all together as one (``all``).

    Emulated participants only where there are no others: nobody's answers are no person's.
    """
    rule = plan.form.staircase
    if rule is None:
        return {}
    entries = {code: read_lines(folder.of(code) / "log.jsonl") for code in folder.codes()}
    people = {code: each for code, each in entries.items() if each and not each[0]["emulated"]}
    found: dict[str, dict[str, Threshold]] = {}
    for condition in plan.form.conditions:
        by_person = {
            code: noticed_in(kept, rule.answer)
            for code, past in (people or entries).items()
            if (kept := _kept(folder, code, past, condition))
        }
        everybody = [each for past in by_person.values() for each in past]
        if everybody:
            found[condition] = {
                name: estimate(past, rule.least, rule.most)
                for name, past in {**by_person, "all": everybody}.items()
            }
    return found


def _kept(folder: StudyFolder, code: str, entries: list[Entry], condition: str) -> list[Entry]:
    return [
        entry
        for entry in entries
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
                **{name: entry[name] for name in OF_A_TRIAL},
                **entry["answers"],
                **workload,
                **({"tlx": tlx_index(workload)} if workload else {}),
                **entry["measures"],
                **{name: entry[name] for name in OF_ITS_END},
                "run": f"people/{code}/{entry['run']}",
                "excluded": folder.excluded(code, entry["trial"]),
            }
        )
    return rows
