"""Was the box held, how steadily, do the copies agree: the measures against plain NumPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column, RecordGroup
from cosim.record import open_run
from cosim.report.measures import SCENARIO_MEASURES, SETTLING, Inspection
from cosim.report.overview import draw_overview
from cosim.report.platform import find_platform
from tests.support.record.format_1 import write_format_1
from tests.support.record.synthetic_run import write

RATE, SECONDS = 1024, 4
ROWS = RATE * SECONDS
TIME = np.arange(ROWS) / RATE


@pytest.fixture
def signals() -> dict[str, np.ndarray]:
    """Two copies 3 mm and 4 mm apart at most; the grasp is at 1 s; a remote finger blinks."""
    touching = (TIME >= 1).astype(np.int64) * 2
    blinking = touching.copy()
    blinking[3000:3002] = 0
    blinking[3500] = 0
    force = np.where(TIME >= 1, 2.0 + 0.1 * np.sin(40 * TIME), 0.0)
    x = 0.02 * TIME
    found: dict[str, np.ndarray] = {
        "vr_a.box_pose.x": x,
        "vr_a.box_pose.y": 0 * x,
        "vr_a.box_pose.theta": 0 * x,
        "vr_b.box_pose.x": x + 0.003 * (TIME > 2),
        "vr_b.box_pose.y": 0 * x - 0.004 * (TIME > 2),
        "vr_b.box_pose.theta": 0 * x + 0.01,
        "vr_a.finger_1.contact_state": touching,
        "vr_a.finger_1.normal_force": force,
        "vr_a.peer_contact_1.finger_1_contact_state": blinking,
        "vr_a.peer_contact_1.finger_1_normal_force": 0.2 * force,
        "vr_a.peer_contact_3.finger_1_contact_state": 0 * touching,
        "vr_a.wall_penetration": np.where(TIME > 3, 1e-3, 0.0),
        "vr_a.finger_1.saturated_ticks": np.clip(np.arange(ROWS) - 1000, 0, 37),
    }
    return found


MEANINGS = {
    "box_pose.x": Meaning.BOX_X,
    "box_pose.y": Meaning.BOX_Y,
    "box_pose.theta": Meaning.BOX_ANGLE,
    "contact_state": Meaning.CONTACT_STATE,
    "normal_force": Meaning.NORMAL_FORCE,
    "wall_penetration": Meaning.WALL_PENETRATION,
    "saturated_ticks": Meaning.SATURATION,
}


def column(name: str, values: np.ndarray, shown: str) -> Column:
    """A column called ``shown`` that means what ``name`` says to a reader of this file."""
    variable = name.partition(".")[2]
    (meaning,) = (meaning for end, meaning in MEANINGS.items() if variable.endswith(end))
    peer, finger = (
        next((int(n) for n in (1, 2, 3) if f"{what}_{n}" in variable), None)
        for what in ("peer_contact", "finger")
    )
    return Column(
        name=shown,
        unit=None,
        is_float=values.dtype == np.float64,
        meaning=meaning,
        belongs_to=Slot(peer, finger),
    )


def record(
    folder: Path, signals: dict[str, np.ndarray], shown: dict[str, str] | None = None
) -> None:
    columns = tuple(
        column(name, values, (shown or {}).get(name, name)) for name, values in signals.items()
    )
    cells = np.stack([values.view(np.int64) for values in signals.values()], axis=1)
    write(folder / "run.h5", (RecordGroup(name="control", period=1, columns=columns),), (cells,))


def measured(folder: Path, name: str, window: tuple[int, int] | None = None) -> float | None:
    with open_run(folder) as run:
        return Inspection(run).value(name, window)


def test_the_measures_of_a_carried_box(tmp_path: Path, signals: dict[str, np.ndarray]) -> None:
    record(tmp_path, signals)
    hold = slice(RATE + round(SETTLING * RATE), None)
    force = signals["vr_a.finger_1.normal_force"][hold]
    blinking = signals["vr_a.peer_contact_1.finger_1_contact_state"][hold]
    expected = {
        "contact_losses": 2,
        "held_fraction": np.mean(blinking != 0),
        "grip_force": 0.2 * force.mean(),
        "force_ripple": force.std(),
        "drift": 0.005,
        "drift_rms": 0.005 * np.sqrt(np.mean(TIME > 2)),
        "drift_angle": 0.01,
        "box_displacement": np.hypot(signals["vr_b.box_pose.x"], 0.004 * (TIME > 2)).max(),
        "wall_penetration": 1e-3,
        "saturated_ticks": 37,
    }
    assert set(expected) == set(SCENARIO_MEASURES)
    for name, value in expected.items():
        assert measured(tmp_path, name) == pytest.approx(value, rel=1e-9), name


def all_measures(folder: Path) -> dict[str, float | None]:
    return {name: measured(folder, name) for name in SCENARIO_MEASURES}


def test_what_signals_are_called_does_not_matter(
    tmp_path: Path, signals: dict[str, np.ndarray]
) -> None:
    record(tmp_path / "ours", signals)
    shown = {
        name: f"{name.partition('.')[0]}.output_{number}" for number, name in enumerate(signals)
    }
    record(tmp_path / "theirs", signals, shown)
    assert all_measures(tmp_path / "theirs") == all_measures(tmp_path / "ours")
    # And a name alone means nothing: these are called like ours, but nobody says what they are.
    columns = tuple(
        Column(name=name, unit=None, is_float=values.dtype == np.float64)
        for name, values in signals.items()
    )
    cells = np.stack([values.view(np.int64) for values in signals.values()], axis=1)
    group = RecordGroup(name="control", period=1, columns=columns)
    write(tmp_path / "foreign" / "run.h5", (group,), (cells,))
    assert set(all_measures(tmp_path / "foreign").values()) == {None}


def test_a_record_of_old_is_measured_by_its_names(
    tmp_path: Path, signals: dict[str, np.ndarray]
) -> None:
    """Version 0.1.0 kept no meanings in the file."""
    record(tmp_path / "new", signals)
    with open_run(tmp_path / "new") as run:
        recorded = run.groups["control"].signals.values()
        columns = tuple(signal.column for signal in recorded)
        cells = np.stack([signal.values.view(np.int64) for signal in recorded], axis=1)
        group = RecordGroup(name="control", period=1, columns=columns)
        write_format_1(tmp_path / "old", group, cells, run.base_rate)
    # Version 0.1.0 did not count saturation.
    wanted = all_measures(tmp_path / "new") | {"saturated_ticks": None}
    assert all_measures(tmp_path / "old") == wanted


def test_a_window_bounds_every_measure(tmp_path: Path, signals: dict[str, np.ndarray]) -> None:
    record(tmp_path, signals)
    assert measured(tmp_path, "contact_losses", (2048, 3001)) == 1
    assert measured(tmp_path, "drift", (0, 2048)) == 0
    assert measured(tmp_path, "wall_penetration", (0, 3000)) == 0


def test_a_box_that_was_dropped_or_never_held_is_not_held(
    tmp_path: Path, signals: dict[str, np.ndarray]
) -> None:
    dropped = signals["vr_a.finger_1.contact_state"].copy()
    dropped[2500:] = 0
    record(tmp_path / "dropped", signals | {"vr_a.finger_1.contact_state": dropped})
    assert measured(tmp_path / "dropped", "contact_losses") == 3
    assert measured(tmp_path / "dropped", "held_fraction") == pytest.approx(964 / 2560)

    never = {name: 0 * values for name, values in signals.items()}
    record(tmp_path / "never", never)
    assert measured(tmp_path / "never", "held_fraction") == 0
    assert measured(tmp_path / "never", "contact_losses") is None


def test_fingers_that_never_touch_do_not_count(
    tmp_path: Path, signals: dict[str, np.ndarray]
) -> None:
    record(tmp_path, signals)
    with open_run(tmp_path) as run:
        platform = find_platform(run.signals)
    assert platform.copies == ("vr_a", "vr_b")
    assert [(str(contact), contact.is_own) for contact in platform.contacts] == [
        ("vr_a finger 1", True),
        ("vr_a, peer 1 finger 1", False),
        ("vr_a, peer 3 finger 1", False),
    ]


def test_a_scenario_without_a_box_has_none_of_them(small_run: Path) -> None:
    for name in SCENARIO_MEASURES:
        assert measured(small_run, name) is None


def test_every_run_has_an_overview(
    tmp_path: Path, small_run: Path, signals: dict[str, np.ndarray]
) -> None:
    """Also one without a box, without a manifest, or without a single row."""
    record(tmp_path / "box", signals)
    record(tmp_path / "empty", {name: values[:0] for name, values in signals.items()})
    for folder in (tmp_path / "box", small_run, tmp_path / "empty"):
        with open_run(folder) as run:
            summaries = {name: signal.summary() for name, signal in run.signals.items()}
            draw_overview(run, folder / "overview.png", summaries)
        assert (folder / "overview.png").read_bytes().startswith(b"\x89PNG")
