"""A path comes first, then a bundled name in any of its spellings; importing costs little."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.scenario import load
from cosim.scenario.source.find import bundled_folder, bundled_names, find_file, shown_name


@pytest.mark.parametrize(
    "name",
    ["single_user", "single_user.yaml", "scenarios/single_user", "scenarios/single_user.yaml"],
)
def test_a_bundled_scenario_has_four_spellings(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert find_file(name) == bundled_folder() / "single_user.yaml"
    assert load(name).name == "single_user"


def test_a_file_of_that_name_comes_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "single_user.yaml").write_text(
        "cohaptic: 1\nduration: 1\nrates: {r: 10}\ncomponents: {p: {fmu: pantograph}}", "utf-8"
    )
    assert list(load("single_user.yaml").components) == ["p"]
    assert "hand_1" in load("single_user").components


def test_a_misspelt_name_gets_a_suggestion() -> None:
    with pytest.raises(InputError) as caught:
        load("two_user_box")
    assert str(caught.value) == (
        "there is no file two_user_box and no bundled scenario of that name. Did you mean "
        "two_users_box?"
    )


def test_files_are_shown_relative_to_where_one_stands(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert shown_name(tmp_path / "a" / "b.yaml") == str(Path("a") / "b.yaml")
    assert shown_name(tmp_path.parent / "b.yaml") == str(tmp_path.parent / "b.yaml")


def test_presets_and_scenarios_are_listed() -> None:
    assert {"single_user", "two_users_box", "presets/lan_2006"} <= set(bundled_names())


def test_importing_the_package_loads_nothing_heavy() -> None:
    code = (
        "import sys, cosim.scenario;"
        "heavy = {'pydantic', 'ruamel', 'numpy', 'fmpy', 'h5py', 'scipy'};"
        "print(sorted(heavy & {name.split('.')[0] for name in sys.modules}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
