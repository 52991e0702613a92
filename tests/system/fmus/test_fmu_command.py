"""``cohaptic fmu`` and ``fmus.find``: what they show, and what they refuse."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest
from click.testing import CliRunner

import fmus
from cosim.base.errors import CohapticError, InputError
from cosim.cli.fmu import command
from fmus import builder
from tests.support.fmus import fmu_support as support


def run(*arguments: str) -> str:
    result = CliRunner().invoke(command, list(arguments))
    if result.exception is not None:
        raise result.exception
    return result.stdout


def test_list_names_every_model() -> None:
    listed = json.loads(run("list", "--json"))["models"]
    assert [model["name"] for model in listed] == list(support.MODELS)
    text = run("list")
    assert all(name in text for name in support.MODELS)


@pytest.mark.parametrize("flavour", ["fmi2", "fmi3", "fmi3-arrays"])
def test_inspect_tells_what_the_table_says(flavour: str) -> None:
    report = json.loads(run("inspect", str(support.path_of("virtual_coupler", flavour)), "--json"))
    assert report["fmi"] == ("2.0" if flavour == "fmi2" else "3.0")
    force = next(v for v in report["variables"] if v["name"] == "force")
    assert force["unit"] == "N"
    assert force["depends_on"] == ["position_a", "velocity_a", "position_b", "velocity_b"]
    delay = next(v for v in report["variables"] if v["name"] == "computation_delay_ticks")
    assert (delay["start"], delay["minimum"], delay["maximum"]) == (0, 0, 8)


@pytest.mark.parametrize("name", support.MODELS)
def test_inspect_reads_for_people(name: str) -> None:
    text = run("inspect", name)
    for variable in support.source(name).model.terminals:
        assert variable.name in text
    assert "parameter:" in text


def test_export_copies_and_does_not_overwrite(tmp_path: Path) -> None:
    folder = tmp_path / "new" / "folder"
    run("export", str(folder), "hand", "signal", "--flavour", "fmi3")
    assert sorted(p.name for p in folder.iterdir()) == ["hand.fmi3.fmu", "signal.fmi3.fmu"]
    assert (folder / "hand.fmi3.fmu").read_bytes() == support.path_of("hand").read_bytes()
    with pytest.raises(InputError, match="--force"):
        run("export", str(folder), "hand")
    run("export", str(folder), "hand", "--force")
    assert len(list(folder.iterdir())) == 4


def test_what_is_no_fmu_is_refused_with_a_sentence(tmp_path: Path) -> None:
    text = tmp_path / "text.fmu"
    text.write_text("no zip")
    empty = tmp_path / "empty.fmu"
    with zipfile.ZipFile(empty, "w") as archive:
        archive.writestr("readme", "")
    broken = tmp_path / "broken.fmu"
    with zipfile.ZipFile(broken, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription fmiVersion='3.0'")
    for path in (text, empty, broken, tmp_path / "missing.fmu"):
        with pytest.raises(InputError) as error:
            run("inspect", str(path))
        assert path.name in str(error.value)
        assert "\n" not in str(error.value).strip()


def test_names_are_suggested() -> None:
    for arguments in (("inspect", "pantografh"), ("build", "pantografh")):
        with pytest.raises(CohapticError, match="pantograph"):
            run(*arguments)
    with pytest.raises(InputError, match="flavour"):
        fmus.find("hand", "fmi1")


def test_a_stale_or_missing_fmu_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert fmus.find("hand").is_file()
    monkeypatch.setenv("COHAPTIC_CACHE_DIR", str(tmp_path / "nothing is known to be fresh"))
    monkeypatch.setattr(builder, "source_digest", lambda _: "0" * 64)
    with pytest.raises(InputError, match=r"older than its sources.*uv sync.*cohaptic fmu build"):
        fmus.find("hand")
    monkeypatch.setattr(builder, "read_note", lambda _: None)
    with pytest.raises(InputError, match=r"has not been built.*uv sync"):
        fmus.find("hand")


def test_build_says_what_it_does() -> None:
    assert run("build", "hand").strip() == "hand: up to date"
