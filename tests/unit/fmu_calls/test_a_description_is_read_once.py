"""An FMU's description is parsed when its content is first met, and recalled bit for bit later."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import fmus
import fmus.probe
from cosim.base.system.store import keep, recall
from cosim.master.fmu import reading
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.reading import read_description
from fmus.archive import FLAVOURS
from tests.support.master.resizable import with_resizable_array

MODELS = [(name, flavour) for name in fmus.model_names() for flavour in FLAVOURS]
PROBES = [("probe_types", "fmi3"), ("probe_fixed_step", "fmi2")]


@pytest.fixture
def fresh(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """An empty cache of the user's, and nothing remembered in this process."""
    monkeypatch.setenv("COHAPTIC_CACHE_DIR", str(tmp_path))
    reading._read.cache_clear()
    yield tmp_path / "descriptions"
    reading._read.cache_clear()


def forgotten(path: Path) -> FmuDescription:
    """The description as another process reads it."""
    reading._read.cache_clear()
    return read_description(path)


def without_parser(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: Any) -> FmuDescription:
        raise AssertionError("it was parsed")

    monkeypatch.setattr(reading, "parse_description", refuse)


@pytest.mark.parametrize(("name", "flavour"), [*MODELS, *PROBES])
def test_what_is_recalled_equals_what_was_parsed(
    name: str, flavour: str, fresh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = (fmus.probe if name.startswith("probe") else fmus).find(name, flavour)
    parsed = read_description(path)
    without_parser(monkeypatch)
    recalled = forgotten(path)
    assert recalled == parsed
    for key, variable in parsed.variables.items():
        assert repr(recalled.variables[key]) == repr(variable)  # also 1 and 1.0, 0.0 and -0.0
    assert list(recalled.variables) == list(parsed.variables)


def test_other_sizes_are_kept_apart(
    fresh: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = with_resizable_array(tmp_path)
    usual = read_description(path)
    structural = next(n for n, v in usual.variables.items() if "structural" in v.causality)
    start = int(usual.variables[structural].start)
    other = read_description(path, {structural: start + 1})
    assert other != usual
    without_parser(monkeypatch)
    reading._read.cache_clear()
    assert read_description(path, {structural: start + 1}) == other


@pytest.mark.parametrize("damage", ["cut", "flipped", "emptied", "another version's", "a folder"])
def test_a_damaged_file_is_silently_made_anew(
    fresh: Path, damage: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = fmus.find("pantograph")
    parsed = read_description(path)
    (file,) = fresh.iterdir()
    content = file.read_bytes()
    match damage:
        case "cut":
            file.write_bytes(content[: len(content) // 2])
        case "flipped":
            place = random.Random(1).randrange(len(content) // 2, len(content))
            changed = bytes([content[place] ^ 1])
            file.write_bytes(content[:place] + changed + content[place + 1 :])
        case "emptied":
            file.write_bytes(b"")
        case "another version's":
            keep(file, {"variables": [("x",)]})
        case _:
            file.unlink()
            file.mkdir()
    assert forgotten(path) == parsed
    assert capfd.readouterr() == ("", "")
    if damage != "a folder":
        assert file.read_bytes() == content


def test_a_cache_that_cannot_be_written_costs_only_time(
    fresh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = fmus.find("hand")
    parsed = read_description(path)
    (file,) = fresh.iterdir()
    file.unlink()
    fresh.rmdir()
    fresh.write_text("a file stands here")
    assert forgotten(path) == parsed


def test_the_store_gives_back_what_it_was_given_or_nothing(tmp_path: Path) -> None:
    content = {"a": [1, 1.5, -0.0, None, True], "b": (b"x", "ü"), 3: {}}
    keep(tmp_path / "deep" / "file", content)
    assert repr(recall(tmp_path / "deep" / "file")) == repr(content)
    assert list((tmp_path / "deep").iterdir()) == [tmp_path / "deep" / "file"]
    whole = (tmp_path / "deep" / "file").read_bytes()
    for length in range(len(whole)):
        (tmp_path / "cut").write_bytes(whole[:length])
        assert recall(tmp_path / "cut") is None


def test_fmpy_stays_out_of_a_run_whose_fmus_are_known() -> None:
    script = (
        "import sys\n"
        "from cosim.scenario import load\n"
        "from cosim.master.run.simulation import assemble\n"
        "with assemble(load('two_users_box', sets=['duration=0.125'])) as simulation:\n"
        "    simulation.run()\n"
        "assert not [name for name in sys.modules if name.split('.')[0] in {'fmpy', 'lxml'}]\n"
    )
    for _ in range(2):  # the first may have to parse
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
