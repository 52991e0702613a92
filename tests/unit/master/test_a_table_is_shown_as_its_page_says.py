"""The columns of a file as outputs: what is shown when, and what is refused by its line."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from cosim.run import run_scenario
from cosim.scenario import load
from tests.support.master.master_support import run, scenario_of

RATE = 256


def written(file: str = "table.csv", duration: float = 1.0, **keys: Any) -> dict[str, Any]:
    return {
        "duration": duration,
        "rates": {"control": RATE, "slow": 64},
        "components": {"hand": {"table": file, "rate": "control", **keys}},
    }


def shown(folder: Path, text: str, signal: str = "hand.x", **keys: Any) -> np.ndarray:
    (folder / "table.csv").write_text(text)
    sink, _ = run(scenario_of(folder, written(**keys)))
    return sink.signal(signal)


@settings(deadline=None, max_examples=25)
@given(
    times=st.lists(st.floats(-0.5, 1.5), min_size=1, max_size=12, unique=True).map(sorted),
    is_linear=st.booleans(),
    offset=st.sampled_from([0.0, -0.25, 0.125]),
    seed=st.integers(0, 99),
)
def test_each_tick_shows_the_row_before_or_the_line(
    tmp_path_factory: pytest.TempPathFactory, times, is_linear, offset, seed
) -> None:
    assume(len(times) == 1 or (times[0] + offset < 1.0 and times[-1] + offset > 0.0))
    values = np.random.default_rng(seed).normal(size=len(times))
    rows = "".join(f"{t!r},{float(v)!r}\n" for t, v in zip(times, values, strict=True))
    keys = {"interpolate": "linear"} if is_linear else {}
    folder = tmp_path_factory.mktemp("table", numbered=True)
    found = shown(folder, f"time,x\n{rows}", time_offset=offset, **keys)
    steps = (np.array(times) + offset) * RATE
    at = np.where(np.abs(steps - np.rint(steps)) <= 0.01, np.rint(steps), steps)
    ticks = np.arange(RATE)
    if is_linear:
        assert found == pytest.approx(np.interp(ticks, at, values), abs=1e-12)
    else:
        before = np.maximum(np.searchsorted(at, ticks, side="right") - 1, 0)
        assert np.array_equal(found, values[before])


@pytest.mark.parametrize(
    "text",
    [
        "t [s], x [mm], y\n0, 1, 2\n0.5, 3, 4\n",
        "x [mm];y;time [ms]\n1;2;0\n3;4;500\n",
        "# a comment\n\nt [s]\tx [mm]\ty\n0\t1\t2\n# another\n0.5\t3\t4\n",
        "t x [mm] y\n0   1 2\n0.5 3 4",
        '\ufefft [s],"x [mm]",y\r\n0,1,2\r\n5e-1,3,4\r\n',
    ],
)
def test_tables_come_in_many_shapes(tmp_path: Path, text: str) -> None:
    (tmp_path / "table.csv").write_text(text, encoding="utf-8")
    document = written()
    document["components"]["user"] = {"fmu": "operator", "rate": "control"}
    document["connections"] = ["hand.x -> user.position[1]"]
    sink, _ = run(scenario_of(tmp_path, document))
    half = [1.0] * (RATE // 2) + [3.0] * (RATE // 2)
    assert sink.signal("hand.x").tolist() == half
    assert sink.signal("hand.y").tolist() == [x + 1 for x in half]
    assert sink.signal("user.position[1]") == pytest.approx(np.array(half) / 1000, abs=1e-15)


def test_columns_that_are_not_chosen_may_hold_anything(tmp_path: Path) -> None:
    text = "t,x,who [dancer],y\n0,1,anna,2\n1,2,nan,3\n"
    (tmp_path / "table.csv").write_text(text)
    sink, _ = run(scenario_of(tmp_path, written(columns=["y", "x"])))
    assert [sink.signal(name)[0] for name in ("hand.x", "hand.y")] == [1.0, 2.0]
    assert len(sink.groups[0].columns) == 2


def test_another_rate_and_a_late_start_see_the_same_curve(tmp_path: Path) -> None:
    text = "t,x\n0,0\n10,10\n"
    keys: dict[str, Any] = {"interpolate": "linear"}
    assert shown(tmp_path, text, **keys)[::4] == pytest.approx(
        shown(tmp_path, text, rate="slow", **keys)
    )
    late = {**written(interpolate="linear"), "start_time": 2}
    sink, _ = run(scenario_of(tmp_path, late))
    assert sink.signal("hand.x")[[0, 128]] == pytest.approx([2.0, 2.5])


def test_a_table_may_be_as_long_as_it_likes(tmp_path: Path) -> None:
    """Rows were limited to 16,384."""
    rows = 100_000
    text = "t,x\n" + "".join(f"{k / 1e5:.5f},{k}\n" for k in range(rows))
    found = shown(tmp_path, text)
    expected = np.floor(np.arange(RATE) / RATE * 1e5 + 1e-6)
    assert np.abs(found - expected).max() <= 5  # rows within 1 % of a step count from it


def test_times_that_were_rounded_come_at_their_tick(tmp_path: Path) -> None:
    rows = "".join(f"{k / RATE:.5f},{k}\n" for k in range(RATE))
    assert shown(tmp_path, f"t,x\n{rows}").tolist() == list(range(RATE))


WRONG = {
    "": (1, "there is nothing in this file"),
    "t,x\n": (1, "no row below the heading"),
    "0,1\n1,2\n": (1, "column 1 of the heading is '0'; write a name"),
    "nan,x\n0,1\n": (1, "no column holds the times"),
    "s,x\n0,1\n": (1, "no column holds the times"),
    "t\n0\n": (1, "no column beside"),
    "t,x,x\n0,1,2\n": (1, "two columns are called x"),
    "t [s],x [mn]\n0,1\n": (1, "x: "),
    "t [sec],x\n0,1\n": (1, "Did you mean s?"),
    "t [mm],x\n0,1\n": (1, "does not convert to s"),
    "t,x\n0,1\n1,nan\n": (3, "x: 'nan' is no finite number"),
    "t,x\n0,1\n1,\n": (3, "x: '' is no finite number"),
    "t,x\n0,1e999\n": (2, "x: '1e999' is no finite number"),
    "t,x\n0,1\n\n1,1_0\n": (4, "x: '1_0' is no finite number"),
    "t,x\n0,1\n1,2,3\n": (3, "there are 3 columns; the heading has 2"),
    "t,x\n0,1\n0,2\n": (3, "times have to rise"),
    "t [min],x\n0,1\n1e308,2\n": (3, "its time in seconds is no finite number"),
    "t;x\n0;1,5\n": (2, "a number has no commas: '1,5' is written 15, or 1.5 with a decimal point"),
    "t,x\n0,\u0661\n": (2, "is no finite number"),
    "t,x\n0,1\u20281,2\n": (2, "there are 3 columns; the heading has 2"),
    "t,time,x\n0,5,1\n": (1, "t and time may both be the times"),
    "T,Time,x\n0,5,1\n": (1, "T and Time may both be the times"),
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_no_table_is_refused_by_its_line(tmp_path: Path, text: str) -> None:
    line, words = WRONG[text]
    with pytest.raises(InputError) as caught:
        shown(tmp_path, text)
    assert f"table.csv:{line}:" in str(caught.value)
    assert words in str(caught.value)


def test_a_time_is_called_so_before_anything_in_capitals(tmp_path: Path) -> None:
    assert shown(tmp_path, "T [K],t [s],x\n300,0,1\n", "hand.T")[0] == 300.0


def test_a_column_is_asked_for_once(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("t,x\n0,1\n")
    with pytest.raises(InputError, match=r"the column 'x' is asked for twice"):
        run(scenario_of(tmp_path, written(columns=["x", "x"])))
    with pytest.raises(InputError, match=r"columns"):
        run(scenario_of(tmp_path, written(columns=[])))


@pytest.mark.parametrize(
    ("rows", "keys"),
    [
        ("1764000000.0,1\n1764000010.0,2\n", {}),
        ("1,1\n2,2\n", {}),
        ("-2,1\n0,2\n", {}),
        ("0,1\n1,2\n", {"time_offset": -1}),
    ],
)
def test_rows_outside_the_run_are_refused(rows: str, keys: dict[str, Any], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"test\.yaml:\d+:\d+: its times, from .* outside the run"):
        shown(tmp_path, f"t,x\n{rows}", **keys)
    assert shown(tmp_path, "t,x\n7,1\n")[0] == 1.0, "one row is a constant"


def test_a_misspelt_column_is_told(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("t,thumb_x\n0,1\n")
    with pytest.raises(InputError, match=r"no column 'thum_x'\. Did you mean thumb_x"):
        run(scenario_of(tmp_path, written(columns=["thum_x"])))


@pytest.mark.parametrize(
    "keys", [{"columns": ["x"]}, {"interpolate": "linear"}, {"time_offset": 1}]
)
def test_a_tables_keys_are_a_tables_alone(tmp_path: Path, keys: dict[str, Any]) -> None:
    document = written()
    document["components"]["hand"] = {"fmu": "signal", "rate": "control", **keys}
    with pytest.raises(InputError, match="belongs to 'table', not to 'fmu'"):
        scenario_of(tmp_path, document)


def test_a_run_goes_on_in_the_table_and_notices_another(tmp_path: Path) -> None:
    (tmp_path / "table.csv").write_text("t,x\n0,0\n1,1\n")
    scenario = scenario_of(tmp_path, written(interpolate="linear"))
    with assemble(scenario) as simulation:
        simulation.start()
        simulation.advance(100)
        snapshot = simulation.snapshot()
        simulation.advance(201)
        later = simulation.snapshot()
    assert len(snapshot.to_bytes()) < 10_000
    with assemble(scenario) as simulation:
        simulation.restore(snapshot)
        simulation.start()
        simulation.advance(201)
        assert simulation.snapshot().to_bytes() == later.to_bytes()
        assert simulation.program.view("hand", "x")[0] == 200 / RATE
    (tmp_path / "table.csv").write_text("t,x\n0,0\n1,2\n")
    with assemble(scenario) as simulation, pytest.raises(InputError, match="other parameters"):
        simulation.restore(snapshot)


def test_the_manifest_keeps_the_files_hash(tmp_path: Path) -> None:
    file = tmp_path / "table.csv"
    file.write_text("t,x\n0,0\n1,1\n")
    scenario = scenario_of(tmp_path, written())
    finished = run_scenario(scenario, tmp_path / "run", figure=False)
    manifest = json.loads((finished.folder / "manifest.json").read_text())
    assert manifest["files"][str(file)] == hashlib.sha256(file.read_bytes()).hexdigest()


def test_a_table_leads_a_hand(tmp_path: Path) -> None:
    """An operator whose trajectory is given has the table's point, and its slope as velocity."""
    (tmp_path / "table.csv").write_text("t [s],x [cm],y [mm]\n0,0,0\n1,10,50\n")
    document = written(interpolate="linear")
    document["components"]["user"] = {
        "fmu": "operator",
        "rate": "control",
        "parameters": {"trajectory": "given", "impedance": "custom", "damping": [2.0, 2.0]},
    }
    document["connections"] = [
        "hand.x -> user.target_position[1]",
        "hand.y -> user.target_position[2]",
    ]
    sink, _ = run(scenario_of(tmp_path, document))
    at = np.arange(RATE) / RATE
    assert sink.signal("user.reference_position[1]") == pytest.approx(0.1 * at, abs=1e-15)
    assert sink.signal("user.reference_velocity[1]")[1:] == pytest.approx(0.1, abs=1e-12)
    assert sink.signal("user.force[2]")[1:] == pytest.approx(0.1, abs=1e-12)
    assert sink.signal("user.reference_velocity[1]")[0] == 0.0


def test_a_table_is_found_from_the_scenarios_folder(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir("/")
    (tmp_path / "table.csv").write_text("t,x\n0,7\n")
    (tmp_path / "s.yaml").write_text(json.dumps({"cohaptic": 1, **written()}))
    sink, _ = run(load(tmp_path / "s.yaml"))
    assert sink.signal("hand.x")[0] == 7.0
    with pytest.raises(InputError, match=r"there is no file .*nowhere\.csv"):
        load(tmp_path / "s.yaml", (), ["components.hand.table=nowhere.csv"])
