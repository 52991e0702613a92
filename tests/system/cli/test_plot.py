"""``cohaptic plot`` draws the same bytes each time, and its text can be read in the file."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli
from cosim.cli.plot import KINDS
from cosim.plot.kinds import KINDS as DRAWN
from cosim.reading import load
from cosim.run import run_scenario


def plot(*arguments: object) -> str:
    said = CliRunner().invoke(
        cli, ["plot", *map(str, arguments)], catch_exceptions=False, standalone_mode=False
    )
    return said.output.strip()


def test_the_command_knows_every_kind() -> None:
    assert set(KINDS) == set(DRAWN)


@pytest.mark.parametrize("suffix", ["svg", "pdf", "png"])
@pytest.mark.parametrize("width", ["one", "two"])
def test_the_bytes_are_the_same(suffix: str, width: str, small_run: Path, tmp_path: Path) -> None:
    files = [tmp_path / f"{number}.{suffix}" for number in range(2)]
    for file in files:
        plot(small_run, "a.*", "--width", width, "--out", file)
    first, second = (file.read_bytes() for file in files)
    assert first == second
    assert len(first) > 1000


@pytest.mark.parametrize(
    ("kind", "patterns", "texts"),
    [
        ("time", ["a.ramp", "a.sine"], ["a.ramp", "time (s)", "N"]),
        ("difference", ["a.ramp", "lan.held"], []),
        ("spectrum", ["a.sine"], ["N/√Hz", "frequency (Hz)"]),
        ("phase", ["a.ramp", "a.sine"], ["a.ramp (m)", "a.sine (N)"]),
        ("histogram", ["a.state"], ["share of the rows", "a.state"]),
    ],
)
def test_axes_say_what_they_are(
    kind: str, patterns: list[str], texts: list[str], small_run: Path, tmp_path: Path
) -> None:
    out = tmp_path / "figure.svg"
    if not texts:
        with pytest.raises(InputError, match=r"in m and lan\.held in m/s"):
            plot(small_run, *patterns, "--kind", kind, "--out", out)
        return
    plot(small_run, *patterns, "--kind", kind, "--out", out)
    drawn = out.read_text(encoding="utf-8")
    assert [text for text in texts if f">{text}<" not in drawn] == []


def test_the_figure_lies_in_the_run_unless_told(small_run: Path) -> None:
    assert plot(small_run, "a.sine") == str(small_run / "plot.png")
    assert (small_run / "plot.png").stat().st_size > 1000


def test_two_runs_are_told_apart_by_their_folders(small_run: Path, tmp_path: Path) -> None:
    other = tmp_path / "other"
    other.mkdir()
    (other / "run.h5").write_bytes((small_run / "run.h5").read_bytes())
    plot(small_run, other, "a.sine", "--out", tmp_path / "figure.svg")
    drawn = (tmp_path / "figure.svg").read_text(encoding="utf-8")
    assert all(f">{text}<" in drawn for text in ("run", "other", "a.sine"))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["a.sine"], "no run folder of that name"),
        (["RUN", "OTHER"], "name the signals to draw, such as"),
        (["RUN", "--kind", "phase"], "--kind without SIGNAL"),
        (["RUN", "--out", "x.pdf"], "the overview is a .png"),
        (["RUN", "a.sine", "--from", "1 s", "--until", "1 s"], "is not after --from"),
    ],
)
def test_what_is_missing_is_said(
    arguments: list[str], sentence: str, small_run: Path, tmp_path: Path, monkeypatch
) -> None:
    monkeypatch.chdir(tmp_path)
    other = tmp_path / "other"
    other.mkdir()
    (other / "run.h5").write_bytes((small_run / "run.h5").read_bytes())
    meant = {"RUN": small_run, "OTHER": other}
    with pytest.raises(InputError, match=sentence):
        plot(*(meant.get(text, text) for text in arguments))
    assert not (tmp_path / "x.pdf").exists()


def test_the_overview_is_drawn_again(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    run_scenario(load("single_user"), folder)
    drawn = (folder / "overview.png").read_bytes()
    (folder / "overview.png").unlink()
    assert plot(folder) == str(folder / "overview.png")
    assert (folder / "overview.png").read_bytes() == drawn
