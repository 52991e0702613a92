"""A figure as a page: every kind is drawn, at any width, dark and light, and zoomed by keyboard."""

from __future__ import annotations

from contextlib import contextmanager

import numpy as np
import pytest

from cosim.base.recording import Column, RecordGroup
from cosim.plot.kinds import KINDS
from cosim.plot.page.document import draw_page
from cosim.plot.series import Span, select
from cosim.record.reader import open_run
from tests.browser.conftest import until
from tests.support.record.synthetic_run import write

pytestmark = pytest.mark.browser

INK = """(() => {
  const canvas = document.querySelector("#plots canvas");
  const bytes = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  return new Set(new Uint32Array(bytes.buffer)).size;
})()"""
ENDS = "[figure.plots[0].plot.scales.x.min, figure.plots[0].plot.scales.x.max]"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Pages of all kinds of one run, whose two signals swing."""
    folder = tmp_path_factory.mktemp("plots")
    time = np.arange(2048) / 1024
    columns = tuple(Column(name=f"a.{name}", unit="m", is_float=True) for name in ("x", "y"))
    values = np.stack([np.sin(20 * time), np.cos(20 * time)], axis=1)
    group = RecordGroup(name="fast", period=1, columns=columns)
    write(folder / "run.h5", (group,), (values.view(np.int64),))
    with open_run(folder) as run:
        for kind, panels in KINDS.items():
            draw_page(panels(select([run], ["a.x", "a.y"]), Span()), folder / f"{kind}.html", kind)
    return folder


@contextmanager
def opened(chromium, file, width=1000, **options):
    context = chromium.new_context(viewport={"width": width, "height": 800}, **options)
    page = context.new_page()
    wrong: list[str] = []
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda said: wrong.append(said.text) if said.type == "error" else None)
    page.goto(f"file://{file}")
    try:
        until(page, "document.documentElement.dataset.ready === 'yes'", ready="figure")
        yield page
        assert wrong == []
    finally:
        context.close()


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_drawn_and_fits_the_window(chromium, folder, kind):
    for width, scheme in ((400, "dark"), (1000, "light"), (1600, "dark")):
        with opened(chromium, folder / f"{kind}.html", width, color_scheme=scheme) as page:
            assert page.evaluate("document.documentElement.scrollWidth") <= width
            assert page.evaluate(INK) > 8
            assert page.evaluate(ENDS) == page.evaluate(ENDS + ".filter(Number.isFinite)")


def test_it_is_zoomed_by_keyboard_and_by_dragging(chromium, folder):
    with opened(chromium, folder / "time.html") as page:
        page.keyboard.press("Tab")
        assert "Plot of a.x, a.y" in page.evaluate("document.activeElement.ariaLabel")
        low, high = page.evaluate(ENDS)
        page.keyboard.press("+")
        page.keyboard.press("ArrowRight")
        near = page.evaluate(ENDS)
        assert near[1] - near[0] == pytest.approx((high - low) / 2)
        assert near[0] > low + (high - low) / 4
        page.keyboard.press("0")
        assert page.evaluate(ENDS) == pytest.approx([low, high])
        box = page.locator(".u-over").bounding_box()
        page.mouse.move(box["x"] + 50, box["y"] + 40)
        page.mouse.down()
        page.mouse.move(box["x"] + 150, box["y"] + 40, steps=4)
        page.mouse.up()
        near = page.evaluate(ENDS)
        assert near[1] - near[0] < (high - low) / 4


def test_a_circle_of_the_phase_plane_is_round(chromium, folder):
    with opened(chromium, folder / "phase.html") as page:
        across, up = page.evaluate(
            "['x', 'y'].map((axis) => Math.abs(figure.plots[0].plot.valToPos(1, axis)"
            " - figure.plots[0].plot.valToPos(-1, axis)))"
        )
        assert across == pytest.approx(up, rel=0.01)
        assert across > 100
