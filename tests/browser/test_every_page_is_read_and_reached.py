"""Contrast AA, in light and dark, and everything by the keyboard: of every page that we make."""

from __future__ import annotations

from contextlib import contextmanager

import pytest

from cosim.plot.kinds import KINDS
from cosim.plot.page.document import draw_page
from cosim.plot.series import Span, select
from cosim.reading import load
from cosim.record.reader import open_run
from cosim.run import run_scenario
from tests.browser.conftest import command, shown, until
from tests.browser.readable import too_faint, unreached

pytestmark = pytest.mark.browser

READY = "document.documentElement.dataset.ready === 'yes'"
NAMES = ["vr_a.finger_1.normal_force", "vr_b.finger_1.normal_force"]


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Addresses of a report and of every kind of plot, and of a run that is played in."""
    folder = tmp_path_factory.mktemp("pages") / "run"
    sets = ["duration=2 s", "expect={}"]
    run_scenario(load("two_users_box", (), sets), folder, figure=False, page=True)
    found = {"report": f"file://{folder / 'report.html'}"}
    with open_run(folder) as run:
        for kind, panels in KINDS.items():
            draw_page(panels(select([run], NAMES), Span()), folder / f"{kind}.html")
            found[kind] = f"file://{folder / kind}.html"
    with command("play", "--no-browser", "--out", str(folder.with_name("take"))) as (address, _):
        yield found | {"play": address}


@contextmanager
def opened(chromium, pages, name):
    if name == "play":
        with shown(chromium, pages[name], color_scheme="light") as page:
            until(page, "cohaptic.run.scene.pointers.length === 2")
            until(page, "document.querySelector('[data-key]')")
            yield page
        return
    context = chromium.new_context(viewport={"width": 1000, "height": 800}, color_scheme="light")
    page = context.new_page()
    page.goto(pages[name])
    try:
        until(page, READY, ready="report" if name == "report" else "figure")
        yield page
    finally:
        context.close()


@pytest.mark.parametrize("name", ["play", "report", *KINDS])
def test_contrast_is_aa_and_every_control_is_reached(chromium, pages, name):
    with opened(chromium, pages, name) as page:
        assert too_faint(page) == []
        assert unreached(page) == []
        page.emulate_media(color_scheme="dark")
        assert too_faint(page) == []
