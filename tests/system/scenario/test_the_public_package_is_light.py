"""``import cohaptic`` costs nothing, and what it offers is all there, typed and usable."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import cohaptic
from cosim.base.errors import InputError

HEAVY = ("numpy", "scipy", "h5py", "pydantic", "ruamel", "fmpy", "matplotlib", "cosim")


def test_importing_it_imports_nothing_heavy() -> None:
    program = "import sys, cohaptic; print(*sys.modules)"
    result = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    loaded = {name.partition(".")[0] for name in result.stdout.split()}
    assert "cohaptic" in loaded
    assert not loaded & set(HEAVY)


def test_it_imports_within_fifty_milliseconds() -> None:
    program = (
        "import time; began = time.process_time(); import cohaptic; "
        "print(time.process_time() - began)"
    )
    times = [
        float(
            subprocess.run([sys.executable, "-c", program], capture_output=True, check=True).stdout
        )
        for _ in range(3)
    ]
    assert min(times) < 0.05


def test_every_name_that_it_promises_is_there() -> None:
    assert set(cohaptic.__all__) <= set(dir(cohaptic))
    for name in cohaptic.__all__:
        found = getattr(cohaptic, name)
        assert callable(found) or found.__all__, name
    with pytest.raises(AttributeError, match="no attribute 'unload'"):
        cohaptic.unload  # noqa: B018
    assert (Path(cohaptic.__file__).parent / "py.typed").is_file()


def test_a_scenario_is_loaded_run_and_read(tmp_path: Path) -> None:
    scenario = cohaptic.load(
        "thesis/free_motion",
        sets=["duration=0.1", "expect=~", "components.vr_a.parameters.compensation=auto"],
    )
    assert "compensation" not in scenario.components["vr_a"].parameters
    finished = cohaptic.run(scenario, tmp_path / "run", figure=False)
    assert finished.error is None
    with cohaptic.open_run(finished.folder) as record:
        assert record.signals


def test_a_folder_of_the_same_name_is_not_taken_for_the_bundled_one(tmp_path: Path) -> None:
    foreign = tmp_path / "scenarios"
    foreign.mkdir()
    (foreign / "__init__.py").write_text("")
    (foreign / "mine.yaml").write_text("cohaptic: 1\n")
    program = (
        "import sys; sys.path.insert(0, sys.argv[1]); "
        "from cosim.scenario.source.find import bundled_folder, bundled_names; "
        "assert 'mine' not in bundled_names(); print(bundled_folder())"
    )
    result = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path)], capture_output=True, text=True, check=True
    )
    assert Path(result.stdout.strip()) != foreign


def test_what_is_no_scenario_is_refused_in_a_sentence() -> None:
    with pytest.raises(InputError, match="no bundled scenario of that name"):
        cohaptic.load("no_such_scenario")
