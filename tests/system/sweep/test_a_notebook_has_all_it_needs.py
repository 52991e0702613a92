"""``import cohaptic`` is light, and what it has is enough to load, edit, run, sweep and look."""

from __future__ import annotations

import subprocess
import sys
import webbrowser
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import cohaptic
from cosim.base.errors import InputError


def test_importing_costs_nothing() -> None:
    code = "import sys; was = set(sys.modules); import cohaptic; print(*set(sys.modules) - was)"
    command = [sys.executable, "-c", code]
    loaded = subprocess.run(command, capture_output=True, text=True, check=True)
    heavy = {"numpy", "pydantic", "h5py", "pandas", "xarray", "cosim"}
    assert not {name.partition(".")[0] for name in loaded.stdout.split()} & heavy


def test_every_name_is_there() -> None:
    assert all(getattr(cohaptic, name) is not None for name in cohaptic.__all__)
    assert set(cohaptic.__all__) <= set(dir(cohaptic))


def test_a_scenario_is_edited_run_and_looked_at(tmp_path: Path) -> None:
    scenario = cohaptic.load("single_axis_distributed", sets=["duration=0.1 s"])
    heavier = cohaptic.edit(scenario, {"components.object_1.parameters.mass": 0.6})
    assert scenario.components["object_1"].parameters["mass"] == 0.4
    assert heavier.components["object_1"].parameters["mass"] == 0.6
    assert cohaptic.spectral_radius(heavier) < 1
    finished = cohaptic.run(heavier, tmp_path / "run", figure=False)
    with cohaptic.open_run(finished.folder) as run:
        frame = run.to_dataframe("hand_?.position")
        data = run.to_xarray("coupler_11")
        assert list(frame.columns) == ["hand_1.position", "hand_2.position"]
        np.testing.assert_array_equal(frame["hand_1.position"], run["hand_1.position"].values)
        assert frame.index[1] == 1 / 1024
        assert frame.attrs["units"]["hand_1.position"] == "m"
        assert data["coupler_11.force"].attrs["units"] == "N"
        assert len(repr(run).splitlines()) <= 12
        assert "coupler_11.position_a" in run._repr_html_()
        with pytest.raises(InputError, match=r"Did you mean hand_1\.position"):
            run.to_dataframe("hand_1.positon")


def test_a_run_goes_on_from_a_snapshot_and_is_drawn(tmp_path: Path) -> None:
    begun = cohaptic.run(
        "single_axis_distributed",
        tmp_path / "begun",
        sets=["duration=0.25 s"],
        snapshots=["0.125 s"],
        figure=False,
    )
    assert begun.error is None
    assert len(repr(begun).splitlines()) <= 12
    assert begun._repr_html_().startswith("<pre>Run ")
    later = cohaptic.resume(
        begun.folder, "0.125 s", tmp_path / "later", duration="0.375 s", figure=False
    )
    with begun.open() as one, later.open() as other:
        assert other.ticks == 384
        values = other["hand_1.position"].values
        np.testing.assert_array_equal(values[: one.ticks], one["hand_1.position"].values)
        picture = other.plot("hand_?.position", start="0.1 s", until=0.2)
        assert picture.file.parent == later.folder
        assert picture._repr_png_().startswith(b"\x89PNG")
        with pytest.raises(InputError, match=r"there is no report\.html"):
            other.show()
        with pytest.raises(InputError, match="is no kind of figure"):
            other.plot("hand_1.position", kind="pie")


def test_the_page_of_a_run_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", opened.append)
    scenario = cohaptic.load("single_axis_distributed", sets=["duration=0.05 s"])
    finished = cohaptic.run(scenario, tmp_path / "run", figure=False, page=True)
    with finished.open() as run:
        assert run.show() == finished.folder / "report.html"
    assert opened == [(finished.folder / "report.html").as_uri()]
    with pytest.raises(TypeError, match="edit"):
        cohaptic.run(scenario, sets=["duration=1 s"])


class Push(cohaptic.Component):
    """Half a newton from tick 10 on."""

    @property
    def variables(self) -> Sequence[cohaptic.Variable]:
        return [cohaptic.Variable(name="value", causality=cohaptic.Causality.OUTPUT, unit="N")]

    def initialise(self, setup: Any, inputs: Mapping[str, Any], outputs: Mapping[str, Any]) -> None:
        self._value = outputs["value"]

    def evaluate(self, tick: int) -> None:
        self._value[0] = 0.5 if tick >= 10 else 0.0


def test_a_class_is_a_component_of_a_scenario(tmp_path: Path) -> None:
    scenario = cohaptic.load("single_axis_distributed", sets=["duration=0.0625 s"])
    part = {"python": Push, "station": "station_1", "rate": "control"}
    own = cohaptic.edit(scenario, {"components.step_1": part})
    finished = cohaptic.run(own, tmp_path / "run", figure=False)
    with finished.open() as run:
        assert run["step_1.value"].values.tolist() == [0.0] * 10 + [0.5] * 54
        assert run["hand_1.position"].values[-1] > 0

    class Local(Push):
        pass

    with pytest.raises(InputError, match="define it at the top of a module"):
        cohaptic.edit(scenario, {"components.step_1.python": Local})


def test_the_theory_draws_a_map_and_an_fmu_is_read() -> None:
    scenario = cohaptic.load("single_axis_distributed")
    vary = {"lan.round_trip_delay": [4, 6], "coupler_12.stiffness": [400, 500]}
    found = cohaptic.theory.radius_map(scenario, vary)
    assert found.radii.shape == (2, 2)
    later = cohaptic.edit(scenario, {"channels.lan.round_trip_delay": 6})
    assert found.radii[1, 0] == cohaptic.theory.spectral_radius(later)
    assert cohaptic.theory.longest_delay(scenario).samples == 2
    assert found.to_xarray().sel({"lan.round_trip_delay": 6}).min() > 1
    assert "of 4 settle" in repr(found)
    assert "hand" in cohaptic.fmu.bundled()
    hand = cohaptic.fmu.read("hand")
    assert (hand.version, hand.variables["mass"].unit) == (3, "kg")
    with pytest.raises(InputError, match="Did you mean hand"):
        cohaptic.fmu.read("hnad")


def test_a_sweep_is_a_table_and_a_grid(tmp_path: Path) -> None:
    scenario = cohaptic.load("single_axis_distributed", sets=["duration=0.15 s"])
    outcome = cohaptic.sweep(
        scenario,
        {"mass": {"set": "object_1.mass", "values": "0.2..0.8/3"}},
        seeds=2,
        measure={"hand_1.position": "rms"},
        out=tmp_path / "sweep",
        workers=0,
    )
    frame, grid = outcome.to_dataframe(), outcome.to_xarray()
    assert list(frame["mass"]) == [0.2, 0.2, 0.5, 0.5, 0.8, 0.8]
    assert grid["hand_1.position rms"].shape == (3, 2)
    assert grid["hand_1.position rms"].values.ravel().tolist() == list(frame["hand_1.position rms"])
    assert outcome.plot().stat().st_size > 1000
    assert repr(outcome).splitlines()[0].endswith("6 good")
