"""The tables of sweeps and of studies are what was found, to a program that knows nothing of us."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import pytest

from cosim.base.errors import InputError
from cosim.reading import FORMS
from cosim.report.measures import SCENARIO_MEASURES
from cosim.study.folder import StudyFolder
from cosim.study.plan import read_study
from cosim.study.questions import NASA_TLX
from cosim.study.table import columns_of, rows_of, units_of
from cosim.sweep.job import RunResult
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.results.table import write_columns, write_table
from cosim.sweep.sweep import SweepOutcome

parquet = pytest.importorskip("pyarrow.parquet")
STUDY = {
    "study": 1,
    "scenario": "single_axis_distributed",
    "conditions": {"one": {}, "two": {}},
    "trials": 2,
    "staircase": {
        "vary": "lan.round_trip_delay",
        "least": 0,
        "most": 16,
        "start": 8,
        "steps": [4],
        "answer": "felt",
        "unit": "samples",
    },
    "questions": {
        "felt": {"ask": "?"},
        "rating": {"ask": "?", "kind": "scale", "least": 1, "most": 7},
        "size": {"ask": "?", "kind": "number"},
        "why": {"ask": "?", "kind": "text"},
    },
    "after_condition": ["nasa_tlx"],
}
TRIAL = {"repetition": 1, "seed": 5, "status": 0, "started": "2026-11-27T10:00:00+00:00"}
ANSWERS = {"felt": True, "rating": 3, "size": 0.5, "why": 'say "ü", then;\nlater'}


@pytest.fixture(name="study")
def _study(tmp_path: Path) -> tuple[Path, StudyFolder]:
    """Two conditions: only the first has its workload, and only its trials measure drift."""
    file = tmp_path / "plan.yaml"
    file.write_text(json.dumps(STUDY))
    folder = StudyFolder(tmp_path / "study")
    folder.begin(read_study(file))
    folder.number_of("P1", emulated=False)
    lines: list[dict[str, Any]] = [{"number": 0, "emulated": False, "order": [], "began": ""}]
    for trial, condition in ((1, "one"), (2, "one"), (3, "two")):
        lines.append(
            TRIAL
            | {"trial": trial, "condition": condition, "value": 8.0, "run": f"trial-{trial:03d}"}
            | {"measures": {"drift": 1e-3} if trial < 3 else {}, "answers": ANSWERS}
            | {"shown_seconds": 8.25, "answered_seconds": 2.5}
        )
    workload = dict.fromkeys(NASA_TLX, 10)
    lines.insert(3, {"form": "nasa_tlx", "condition": "one", "answers": workload})
    log = folder.of("P1") / "log.jsonl"
    log.parent.mkdir(parents=True)
    log.write_text("".join(json.dumps(line) + "\n" for line in lines))
    folder.exclude("P1", 2, "slept", "Ada")
    return file, folder


def test_a_study_is_read_back_as_it_was(study: tuple[Path, StudyFolder], tmp_path: Path) -> None:
    plan, folder = study
    units = units_of(read_study(plan), {n: m.unit for n, m in SCENARIO_MEASURES.items()})
    write_columns(columns_of(rows_of(folder)), units, tmp_path / "trials.parquet")
    table = parquet.read_table(tmp_path / "trials.parquet")
    columns = table.to_pydict()
    types = {name: str(table.schema.field(name).type) for name in columns}
    assert types["participant"] == types["condition"] == types["why"] == "string"
    assert types["felt"] == types["emulated"] == "bool"
    assert types["trial"] == types["rating"] == types["seed"] == "int64"
    assert types["value"] == types["drift"] == types["tlx"] == "double"
    assert columns["why"] == [ANSWERS["why"]] * 3
    assert columns["drift"] == [1e-3, 1e-3, None], "what was not measured is missing, and no zero"
    assert columns["tlx"] == [10.0, 10.0, None], "the second condition's form is not answered yet"
    assert columns["excluded"] == ["", "slept", ""], "it is marked, and still there"
    found = {
        name: (table.schema.field(name).metadata or {}).get(b"unit") for name in table.column_names
    }
    assert found["value"] == b"samples"
    assert found["drift"] == b"m"
    assert found["shown_seconds"] == b"s"
    assert found["rating"] is None


def test_a_study_is_the_same_in_csv(study: tuple[Path, StudyFolder], tmp_path: Path) -> None:
    _, folder = study
    write_columns(columns_of(rows_of(folder)), {}, tmp_path / "trials.csv")
    with (tmp_path / "trials.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["why"] for row in rows] == [ANSWERS["why"]] * 3
    assert [row["drift"] for row in rows] == ["0.001", "0.001", ""]
    assert [row["excluded"] for row in rows] == ["", "slept", ""]


def swept(tmp_path: Path, **vary: Any) -> Any:
    """The table of a sweep in which nothing was run but the first two points."""
    plan = plan_of(Request(scenario="single_axis_distributed", vary=vary), FORMS)
    results = tuple(
        RunResult(n, "k", plan.points[n], "good", measures={"drift": 0.5 if n else float("nan")})
        for n in range(2)
    )
    write_table(SweepOutcome(plan, tmp_path, results), tmp_path / "t.parquet")
    return parquet.read_table(tmp_path / "t.parquet")


def test_a_sweep_says_its_units(tmp_path: Path) -> None:
    table = swept(tmp_path, **{"lan.round_trip_delay": "0, 20 ms", "duration": [1, 2]})
    assert table.column("lan.round_trip_delay").to_pylist() == [0.0, 0.0]
    units = {f.name: (f.metadata or {}).get(b"unit") for f in table.schema}
    assert units["lan.round_trip_delay"] == b"ms"
    assert units["drift"] == b"m"
    assert units["seconds"] == b"s"
    assert units["duration"] is None
    first, second = table.column("drift").to_pylist()
    assert math.isnan(first), "a NaN stays one"
    assert second == 0.5


def test_values_in_several_units_are_refused() -> None:
    """In the table they would be numbers without: 5 mm and 1 cm as 5 and 1."""
    for given in ("5 ms, 0.1 s", ["5 ms", 0.1]):
        with pytest.raises(InputError, match=r"lan\.delay: write all values in one unit, not .*ms"):
            plan_of(Request(scenario="two_users_box", vary={"lan.delay": given}), FORMS)


def test_words_beside_numbers_keep_their_units(tmp_path: Path) -> None:
    vary = {"a": {"set": ["object_1.compensation"], "values": ["auto", "5 N.s/m"]}}
    assert swept(tmp_path, **vary).column("a").to_pylist() == ["auto", "5 N.s/m"]


def test_true_beside_a_number_is_a_word(tmp_path: Path) -> None:
    vary = {"a": {"set": ["hand_1.mass"], "values": [True, 2]}}
    assert swept(tmp_path, **vary).column("a").to_pylist() == ["true", "2"]


@pytest.mark.parametrize("name", ["status", "seconds", "drift", "spectral_radius"])
def test_no_variable_takes_a_columns_name(name: str) -> None:
    """It would stand in its place, and nobody would be told."""
    vary = {name: {"set": ["hand_1.mass"], "values": [1, 2]}}
    with pytest.raises(InputError, match=f"{name} is a column of every sweep's table"):
        plan_of(Request(scenario="single_axis_distributed", vary=vary), FORMS)


def test_a_value_that_is_written_twice_is_in_every_place_of_a_dataset(tmp_path: Path) -> None:
    pytest.importorskip("xarray")
    plan = plan_of(Request(scenario="single_axis_distributed", vary={"duration": [1, 1]}), FORMS)
    results = tuple(
        RunResult(n, "k", plan.points[n], "good", measures={"drift": 2.0}) for n in range(2)
    )
    found = SweepOutcome(plan, tmp_path, results).to_xarray()
    assert found["drift"].values.tolist() == [2.0, 2.0]
