"""A scenario comes from a file, a pipe or standard input; what is none of them is told apart."""

from __future__ import annotations

import io
import os
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from threading import Thread

import pytest

from cosim.analysis import load_tuned
from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from cosim.scenario import load


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _pipe(text: str) -> str:
    """A pipe as a shell's ``<(command)`` gives it: it can be read once."""
    reading, writing = os.pipe()

    def write() -> None:
        with os.fdopen(writing, "w") as file:
            file.write(text)

    Thread(target=write).start()
    return f"/dev/fd/{reading}"


@pytest.mark.parametrize("loader", [load, load_tuned])
def test_standard_input(
    loader: Callable[..., object], here: Path, small: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    (here / "rates.yaml").write_text("rates: {network: 64}", encoding="utf-8")
    text = small.replace("title:", "include: rates.yaml\ntitle:").replace(", network: 128", "")
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))
    scenario = loader("-")
    assert scenario.rates["network"] == 64
    assert scenario.name == "standard_input"


def test_a_mistake_in_standard_input_has_its_line(
    here: Path, small: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = small.replace("2 s", "soon").encode()
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text)))
    with pytest.raises(InputError, match=r"standard input:3:11: duration: 'soon' is not"):
        load("-")


def test_pipes_for_scenario_and_overlay(here: Path, small: str) -> None:
    (here / "rates.yaml").write_text("rates: {network: 64}", encoding="utf-8")
    overlay = _pipe("include: rates.yaml\nduration: 3 s")
    scenario = load_tuned(_pipe(small), [overlay])
    assert (scenario.duration, scenario.rates["network"]) == (3, 64)


def test_what_is_no_scenario_is_told_for_what_it_is(here: Path) -> None:
    for name in ("model.fmu", "system.ssp", "other.zip"):
        with zipfile.ZipFile(here / name, "w") as archive:
            archive.writestr("a", "b")
    (here / "run.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
    (here / "wide.yaml").write_bytes("cohaptic: 1".encode("utf-16"))
    (here / "binary").write_bytes(b"abc\0def")
    (here / "loop").symlink_to("loop")
    (here / "dangling").symlink_to("nowhere.yaml")
    (here / "run").mkdir()
    (here / "run" / "scenario.resolved.yaml").write_text("cohaptic: 1")
    (here / "folder").mkdir()
    (here / "folder" / "a.yaml").write_text("cohaptic: 1")
    for name, sentence in {
        "model.fmu": (
            "model.fmu:1:1: this is an FMU, not a scenario; a scenario names it: "
            "'{fmu: FILE.fmu, rate: …}'."
        ),
        "system.ssp": "system.ssp:1:1: this is an SSP package, not a scenario, which is YAML text.",
        "other.zip": "other.zip:1:1: this is a zip archive; a scenario is YAML text.",
        "run.h5": (
            "run.h5:1:1: this is a record (HDF5); the run's scenario is scenario.resolved.yaml "
            "beside it."
        ),
        "wide.yaml": "wide.yaml:1:1: this is text in UTF-16; save the file as UTF-8.",
        "binary": "binary:1:1: this is a binary file; a scenario is YAML text.",
        "loop": "cannot read loop: its links lead in a circle.",
        "dangling": "dangling is a link to nowhere.yaml, which does not exist.",
        "/dev/null": "/dev/null is a device or socket, not a scenario file.",
        "run": (
            "run is a folder, not a scenario file. It is the folder of a run; its scenario is "
            "run/scenario.resolved.yaml."
        ),
        "folder": "folder is a folder, not a scenario file. In it is folder/a.yaml.",
    }.items():
        with pytest.raises(InputError) as caught:
            load(name)
        assert str(caught.value) == sentence


SUGGESTED = {
    "two_user_box": "two_users_box",
    "two_users_box_centralised": "two_users_box_centralized",
    "Single_User.yaml": "single_user",
    "scenarios/single_usr.yaml": "single_user",
    "lan_2060": "presets/lan_2006",
    "my_scenaro": "my_scenario.yaml",
}
ABSURD = ("nothing.yaml", "test.yaml", "box", "user", "lan", "a", "thesis", "my.yaml")


def test_a_missing_file_is_compared_with_what_is_there(here: Path) -> None:
    (here / "my_scenario.yaml").write_text("cohaptic: 1")
    for written, meant in SUGGESTED.items():
        with pytest.raises(InputError) as caught:
            load(written)
        assert str(caught.value).endswith(f" Did you mean {meant}?"), written
    for written in ABSURD:
        with pytest.raises(InputError) as caught:
            load(written)
        assert "Did you mean" not in str(caught.value), written


def test_a_preset_is_no_overlay(here: Path, small: str) -> None:
    (here / "s.yaml").write_text(small)
    with pytest.raises(InputError) as caught:
        load("s.yaml", ["lan_2006"])
    assert str(caught.value) == (
        "lan_2006 is a preset for a part of a scenario; write 'include: lan_2006' in the component "
        "or channel that is to have it."
    )


def test_the_plain_reader_names_the_one_that_computes() -> None:
    word = "components.vr_a.parameters.compensation"
    scenario = load("two_users_box", (), [f"{word}=~", f"{word}=auto"])
    with pytest.raises(InputError, match=r"is computed by cohaptic\.load, and cosim"):
        assemble(scenario)
