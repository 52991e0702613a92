"""What a caller from Python gives is used, or refused in a sentence; none is taken for another."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cohaptic
from cosim.base.errors import InputError

PUSH = {"python": "tests.support.forms.parts:Ramp", "rate": "control"}


@pytest.fixture(scope="module")
def single() -> Any:
    return cohaptic.load("single_user", sets=["duration=0.0625 s"])


@pytest.mark.parametrize("wrong", ["duration=1 s", {"duration": "1 s"}, [3], 3, Path("x")])
def test_a_text_is_no_list_of_texts(wrong: Any, single: Any, tmp_path: Path) -> None:
    told = r"is a list of texts"
    for name, call in {
        "sets": lambda: cohaptic.load("single_user", sets=wrong),
        "overlays": lambda: cohaptic.load("single_user", wrong),
        "snapshots": lambda: cohaptic.run(single, tmp_path / "run", snapshots=wrong),
        "sets of": lambda: cohaptic.sweep("single_user", seeds=2, sets=wrong),
    }.items():
        if name == "overlays" and wrong == [3]:
            continue
        with pytest.raises(TypeError, match=f"{name.split()[0]} {told}"):
            call()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("value", "ticks"),
    [
        (np.float32(0.125), 128),
        (np.float64(0.125), 128),
        (np.array(0.125), 128),
        (Fraction(1, 8), 128),
        (np.int64(1), 1024),
    ],
)
def test_a_number_is_a_number_whoevers_it_is(value: Any, ticks: int, single: Any) -> None:
    assert cohaptic.edit(single, {"duration": value}).ticks == ticks
    assert cohaptic.edit("single_user", {"duration": value}).ticks == ticks


def test_arrays_and_paths_are_values(single: Any) -> None:
    edited = cohaptic.edit(single, {"record": np.array(["hand_1.position"])})
    assert [each.pattern for each in edited.record] == ["hand_1.position"]
    with pytest.raises(InputError, match="nowhere"):
        cohaptic.edit(single, {"components.hand_1.fmu": Path("nowhere.fmu")})


@pytest.mark.parametrize("wrong", ["duration=1", ["duration=1"], None, {3: 1}])
def test_an_edit_is_a_mapping(wrong: Any, single: Any) -> None:
    with pytest.raises(TypeError, match="values is a mapping from places to values"):
        cohaptic.edit(single, wrong)


@pytest.mark.parametrize("wrong", [3, None, ["single_user"]])
def test_a_scenario_is_one(wrong: Any) -> None:
    for call in (
        lambda: cohaptic.run(wrong),
        lambda: cohaptic.edit(wrong, {}),
        lambda: cohaptic.spectral_radius(wrong),
        lambda: cohaptic.theory.longest_delay(wrong),
        lambda: cohaptic.theory.radius_map(wrong, {}),
    ):
        with pytest.raises(TypeError, match="a scenario is a name, a file"):
            call()


def test_the_theory_takes_a_name() -> None:
    by_name = cohaptic.spectral_radius("single_user")
    assert by_name == cohaptic.spectral_radius(cohaptic.load("single_user"))


class Unasked(cohaptic.Component):
    @property
    def variables(self) -> list[cohaptic.Variable]:
        return [cohaptic.Variable(name="x", causality=cohaptic.Causality.OUTPUT)]

    def initialise(self, setup: Any, inputs: Any, outputs: Any) -> None:
        self.x = outputs["x"]

    def evaluate(self, tick: int) -> None:
        self.x[0] = tick


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"hnad_1": Unasked()}, "there is no component hnad_1. Did you mean hand_1?"),
        ({"hand_1": Unasked()}, "hand_1 is an FMU, which no object stands for"),
        ({"own": 3}, "for own there is 3, which is no component"),
        ({"own": Unasked}, "which is no component"),
        ([Unasked()], "is no mapping from names to components"),
    ],
)
def test_an_object_that_stands_for_nothing_is_refused(
    given: Any, told: str, single: Any, tmp_path: Path
) -> None:
    with_own = cohaptic.edit(single, {"components.own": PUSH})
    with pytest.raises(InputError) as caught:
        cohaptic.run(with_own, tmp_path / "run", components=given, figure=False)
    assert told in str(caught.value)
    assert not (tmp_path / "run").exists()


def test_a_run_that_is_read_says_what_cannot_be(single: Any, tmp_path: Path) -> None:
    finished = cohaptic.run(single, tmp_path / "run", figure=False)
    with finished.open() as run:
        signal = run["hand_1.position"]
        whole = signal.values
        for rows in (slice(None, None, -1), slice(5, 900), slice(-3, None), slice(9, 2, -3)):
            assert np.array_equal(signal[rows], whole[rows]), rows
        assert signal[900:].shape == signal[5:2].shape == (0,)
        with pytest.raises(TypeError, match=r"rows are read by a slice, such as \[0:10\], not 3"):
            signal[3]  # pyright: ignore[reportArgumentType]
        with pytest.raises(InputError, match="no signal 3 was recorded"):
            run[3]  # pyright: ignore[reportArgumentType]
        for time in ("1 N", float("nan"), "soon"):
            with pytest.raises(InputError):
                run.plot("hand_1.position", start=time, file=tmp_path / "figure.png")
        run.plot("hand_1.position", start=np.float32(0.03125), file=tmp_path / "figure.png")
    with pytest.raises(InputError, match="the run that it is of was closed"):
        signal.values  # noqa: B018


@pytest.mark.parametrize("workers", [1.5, "two", -1])
def test_workers_are_a_whole_number(workers: Any, single: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="workers"):
        cohaptic.sweep(single, seeds=2, workers=workers, out=tmp_path / "sweep")
    assert not (tmp_path / "sweep").exists()
