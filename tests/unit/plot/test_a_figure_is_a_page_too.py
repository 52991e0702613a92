"""Every kind of figure is a page: one file that loads nothing and has the figure's numbers."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from cosim.base.errors import InputError
from cosim.base.recording import Column, RecordGroup
from cosim.cli import cli
from cosim.plot.kinds import KINDS, Line, Panel
from cosim.plot.page.document import POINTS, decode, draw_page, encode
from cosim.plot.series import Span, select
from cosim.record.reader import open_run
from tests.support.record.synthetic_run import write


@given(arrays(np.float64, st.integers(0, 60)))
def test_numbers_are_the_same_bit_for_bit(values: np.ndarray) -> None:
    assert decode(encode(values)).tobytes() == values.tobytes()


def data_of(page: Path) -> list[dict]:
    text = page.read_text(encoding="utf-8")
    assert not re.search(r'(src|href)="(?!data:,)', text)
    assert not re.search(r"url\(|@import", text)
    return json.loads(re.search(r'id="data">(.*?)</script>', text, re.DOTALL)[1])


@pytest.fixture
def swings(tmp_path: Path) -> Path:
    """A run of two signals of one unit, a second long."""
    time = np.arange(1024) / 1024
    columns = tuple(Column(name=f"a.{name}", unit="m", is_float=True) for name in ("x", "y"))
    values = np.stack([np.sin(20 * time), np.cos(33 * time)], axis=1)
    folder = tmp_path / "run"
    folder.mkdir()
    group = RecordGroup(name="fast", period=1, columns=columns)
    write(folder / "run.h5", (group,), (values.view(np.int64),))
    return folder


NAMES = ["a.x", "a.y"]


@pytest.mark.parametrize("kind", KINDS)
def test_a_page_has_what_the_figure_has(kind: str, swings: Path, tmp_path: Path) -> None:
    with open_run(swings) as run:
        panels = KINDS[kind](select([run], NAMES), Span())
        draw_page(panels, tmp_path / "page.html", "</script><b>")
    found = data_of(tmp_path / "page.html")
    assert "<b>" not in (tmp_path / "page.html").read_text(encoding="utf-8")
    for panel, shown in zip(panels, found, strict=True):
        assert (shown["x"], shown["y"], shown["form"]) == (panel.x, panel.y, panel.form)
        for line, told in zip(panel.lines, shown["lines"], strict=True):
            values = decode(told["y"])[: line.y.size]
            assert told["label"] == line.label
            assert values.tobytes() == line.y.astype(float).tobytes()
            assert decode(told["x"]).tobytes() == line.x.astype(float).tobytes()


def test_a_long_line_of_any_kind_keeps_its_extremes_and_no_more_points_than_are_drawn(
    tmp_path: Path,
) -> None:
    rows = 3 * POINTS
    way = np.cumsum(np.random.default_rng(1).normal(size=(2, rows)), axis=1)
    lines = {"steps": np.arange(rows) / 1024.0, "line": way[0]}
    panels = [
        *(Panel("x", "y", (Line("", x, way[1]),), form) for form, x in lines.items()),
        Panel("f", "y", (Line("", lines["steps"][1:], way[1][1:]),), "line", is_logarithmic=True),
    ]
    draw_page(panels, tmp_path / "page.html")
    for panel, shown in zip(panels, data_of(tmp_path / "page.html"), strict=True):
        ((told,), (line,)) = shown["lines"], panel.lines
        x, y = decode(told["x"]), decode(told["y"])
        assert POINTS / 4 < x.size == y.size <= POINTS
        for drawn, whole in ((x, line.x), (y, line.y)):
            assert (drawn.min(), drawn.max()) == (whole.min(), whole.max())
            assert (drawn[0], drawn[-1]) == (whole[0], whole[-1])
        assert {*zip(x, y, strict=True)} <= {*zip(line.x, line.y, strict=True)}


def test_the_command_writes_it_and_refuses_a_width(swings: Path, tmp_path: Path) -> None:
    words = ["plot", str(swings), *NAMES, "--out", str(tmp_path / "page.html")]
    done = CliRunner().invoke(cli, words)
    assert done.exit_code == 0, done.output
    assert len(data_of(tmp_path / "page.html")) == 1
    refused = CliRunner().invoke(cli, [*words, "--width", "one"])
    assert isinstance(refused.exception, InputError)
    assert "as wide as its window" in str(refused.exception)
