"""``import cohaptic`` is light, and what it has is enough to load, edit, run, sweep and look."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

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
