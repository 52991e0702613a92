"""Was the box held, how steadily, do the copies agree: the measures against plain NumPy."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from cosim.base.recording import Column, RecordGroup
from cosim.record import open_run
from cosim.report.measures import SCENARIO_MEASURES, SETTLING
from cosim.report.overview import draw_overview
from cosim.report.platform import find_platform
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
    }
    return found


def record(folder: Path, signals: dict[str, np.ndarray]) -> None:
    columns = tuple(
        Column(name=name, unit=None, is_float=values.dtype == np.float64)
        for name, values in signals.items()
    )
    cells = np.stack([values.view(np.int64) for values in signals.values()], axis=1)
    write(folder / "run.h5", (RecordGroup(name="control", period=1, columns=columns),), (cells,))


def measured(folder: Path, name: str, window: tuple[int, int] | None = None) -> float | None:
    with open_run(folder) as run:
        return SCENARIO_MEASURES[name].take(run, window)


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
    }
    assert set(expected) == set(SCENARIO_MEASURES)
    for name, value in expected.items():
        assert measured(tmp_path, name) == pytest.approx(value, rel=1e-9), name


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
