"""``cohaptic intent`` takes for fingers what stations say of them, whatever that is called."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.recording import Column, RecordGroup
from cosim.cli.recorded.told_fingers import AXES, packet_rate, predicting, told_fingers
from cosim.reading import load
from cosim.record import open_run
from cosim.record.reader import RUN_FILE
from cosim.record.writer import Recorder

ROWS = 64
TOLD = [meaning for axis in AXES for meaning in axis]
UNITS = dict(zip(TOLD, ("m", "m/s", "m", "m/s"), strict=True))
NAMES = dict(zip(TOLD, ("ort_x", "tempo_x", "ort_y", "tempo_y"), strict=True))
NUMBERS = ("acceleration", "decay")


def column(name: str, meaning: Meaning | None, unit: str, finger: int | None = 1) -> Column:
    return Column(
        name=name, unit=unit, is_float=True, meaning=meaning, belongs_to=Slot(None, finger)
    )


def hand(component: str = "mine", **units: str) -> list[Column]:
    """One finger under names that say nothing; ``units`` by meaning."""
    return [
        column(f"{component}.{NAMES[each]}", each, units.get(each, UNITS[each])) for each in TOLD
    ]


def recorded(folder: Path, *groups: list[Column], value: float = 0.25) -> Path:
    """A run with these columns, a group a rate: 1024 Hz, half of that, and so on."""
    folder.mkdir()
    with Recorder(folder / RUN_FILE, ROWS) as recorder:
        recorder.begin(
            [
                RecordGroup(name=f"group_{n}", period=2**n, columns=tuple(columns))
                for n, columns in enumerate(groups)
            ],
            Fraction(1024),
        )
        for number, columns in enumerate(groups):
            rows = ROWS // 2**number
            cells = recorder.buffer(number, rows)
            cells[:] = np.full((rows, len(columns)), value).view(np.int64)
            recorder.commit(number, 0, rows)
    return folder


def refused(folder: Path, *groups: list[Column], wanted: tuple[str, ...] = (), **more) -> str:
    with open_run(recorded(folder, *groups, **more)) as run, pytest.raises(InputError) as error:
        [finger.moves() for finger in told_fingers(run, wanted)]
    return str(error.value)


def test_names_that_say_nothing_are_found_by_their_meaning(tmp_path: Path) -> None:
    with open_run(recorded(tmp_path / "run", [*hand("mine"), *hand("yours")])) as run:
        assert [each.name for each in told_fingers(run)] == ["mine.finger_1", "yours.finger_1"]
        (finger,) = told_fingers(run, ("yours.finger_1",))
        position, velocity = finger.moves()
    assert position.shape == velocity.shape == (ROWS, 2)
    assert np.all(position == 0.25)


def test_names_of_a_workstation_without_a_meaning_are_no_fingers(tmp_path: Path) -> None:
    names = [
        f"link_b.vr_b.shared.finger_1_{what}[{axis}]"
        for what in ("position", "velocity")
        for axis in (1, 2)
    ]
    said = refused(tmp_path / "run", [column(name, None, "m") for name in names])
    assert "no signal that means 'told_x'" in said
    assert "record what stations send" in said


@pytest.mark.parametrize("missing", TOLD)
def test_a_finger_without_one_of_its_signals_is_refused_by_that(tmp_path, missing) -> None:
    columns = [each for each in hand() if each.meaning is not missing]
    said = refused(tmp_path / "run", [*columns, *hand("yours")])
    assert f"no signal that means its '{missing}'" in said
    assert "mine.finger_1" in said


def test_two_signals_that_mean_the_same_are_refused_by_both_names(tmp_path: Path) -> None:
    twice = column("mine.nochmal", Meaning.TOLD_Y, "m")
    said = refused(tmp_path / "run", [*hand(), twice])
    assert "several signals that mean 'told_y' of mine.finger_1" in said
    assert "mine.ort_y and mine.nochmal" in said


def test_another_finger_is_refused_with_the_one_that_was_meant(tmp_path: Path) -> None:
    said = refused(tmp_path / "run", hand(), wanted=("mine.finger_2",))
    assert "no finger 'mine.finger_2'" in said
    assert "There are mine.finger_1" in said


def test_fingers_at_two_rates_are_refused(tmp_path: Path) -> None:
    said = refused(tmp_path / "run", hand("mine"), hand("yours"))
    assert "at 512 Hz" in said
    assert "at 1024 Hz" in said


def test_what_is_no_number_is_refused(tmp_path: Path) -> None:
    said = refused(tmp_path / "run", hand(), value=float("nan"))
    assert f"{ROWS} of its {ROWS} values are no numbers" in said


def test_units_are_taken_at_their_word(tmp_path: Path) -> None:
    with open_run(recorded(tmp_path / "run", hand(told_x="mm"))) as run:
        position, _ = told_fingers(run)[0].moves()
    assert position[0] == pytest.approx([0.25e-3, 0.25])
    said = refused(tmp_path / "other", hand(told_x="N"))
    assert "means 'told_x' and is in N, which is no m" in said


def test_packets_are_as_frequent_as_the_runs_channel_says(tmp_path: Path) -> None:
    scenario = load("two_users_box", sets=("rates.network=64 Hz",))
    with open_run(recorded(tmp_path / "run", [*hand("vr_a"), *hand("alone")])) as run:
        a, alone = told_fingers(run)
    assert packet_rate(scenario, [a], tmp_path) == 64
    with pytest.raises(InputError, match="no channel carries what alone tell"):
        packet_rate(scenario, [alone], tmp_path)


def test_who_predicts_is_told_by_what_its_parameters_mean() -> None:
    found = predicting(load("two_users_box"), Path("run"), NUMBERS)
    assert found == {"vr_a": "predictor", "vr_b": "predictor"}
    with pytest.raises(InputError, match="parameter that means 'predictor'"):
        predicting(load("single_axis_distributed"), Path("run"), NUMBERS)
