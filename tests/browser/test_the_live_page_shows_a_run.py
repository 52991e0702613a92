"""A run in a browser: its scene, its plots, its numbers, at every width, dark and light."""

from __future__ import annotations

import time

import pytest

from tests.browser.conftest import command, readout, shown, until
from tests.browser.readable import too_faint, unreached

pytestmark = pytest.mark.browser

SIZES = (400, 1000, 1600)


@pytest.fixture(scope="module")
def address(tmp_path_factory):
    out = tmp_path_factory.mktemp("live") / "run"
    words = ("--realtime", "--live", "--duration", "120", "--no-figure", "--out", str(out))
    with command("run", "two_users_box", *words) as (found, _):
        yield found


def colours(page):
    """How many different colours the scene has."""
    return page.evaluate(
        """() => {
          const canvas = document.getElementById("scene");
          const pen = canvas.getContext("2d");
          const bytes = pen.getImageData(0, 0, canvas.width, canvas.height).data.buffer;
          return new Set(new Uint32Array(bytes)).size;
        }"""
    )


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", SIZES)
def test_the_scene_is_drawn_and_nothing_sticks_out(chromium, address, width, scheme):
    with shown(chromium, address, width, 900, color_scheme=scheme) as page:
        until(page, "cohaptic.time > 3.2")
        assert colours(page) > 8
        assert page.evaluate("document.documentElement.scrollWidth") <= width
        assert page.inner_text("#state") == "The run goes on."
        label = page.get_attribute("#scene", "aria-label")
        assert "a1, a2, b1, b2" in label
        assert page.locator("#plots figure").count() == 4
        assert page.inner_text("#legend").count("\n") >= 4


def test_contrast_is_aa_and_every_control_is_reached(chromium, address):
    with shown(chromium, address) as page:
        until(page, "document.querySelector('[data-key]')")
        assert too_faint(page) == []
        assert unreached(page) == []
        page.emulate_media(color_scheme="dark")
        assert too_faint(page) == []


def test_any_signal_is_plotted_and_an_unknown_one_is_refused(chromium, address):
    with shown(chromium, address) as page:
        page.fill("#signal", "vr_b.finger_1.normal_force")
        page.press("#signal", "Enter")
        until(
            page,
            "document.querySelector('#plots').innerText.includes('vr_b.finger_1.normal_force')",
        )
        page.fill("#signal", "vr_b.nothing")
        page.press("#signal", "Enter")
        assert page.evaluate("document.getElementById('signal').validationMessage") != ""


def test_the_plots_begin_where_the_run_does(chromium, tmp_path):
    """Their first seconds are room that the lines grow into, and no time before the run."""
    words = ("--realtime", "--live", "--set", "start_time=100 s", "--duration", "60")
    with (
        command("run", "two_users_box", *words, "--no-figure", "--out", str(tmp_path)) as (at, _),
        shown(chromium, at) as page,
    ):
        until(page, "cohaptic.times !== null && cohaptic.time < 104")
        assert page.evaluate("cohaptic.times") == {"min": 100, "max": 105}
        until(page, "cohaptic.time > 106")
        until(page, "cohaptic.times.min > 100.5")
        width = page.evaluate("cohaptic.times.max - cohaptic.times.min")
        assert abs(width - 5) < 1e-9


def test_held_plots_stand_still_while_the_run_goes_on(chromium, address):
    with shown(chromium, address) as page:
        page.click("#freeze")
        picture = "document.querySelector('#plots canvas').toDataURL()"
        time.sleep(0.2)
        before, moment = page.evaluate(picture), page.evaluate("cohaptic.time")
        time.sleep(0.5)
        assert page.evaluate(picture) == before
        assert page.evaluate("cohaptic.time") > moment + 0.3
        page.click("#freeze")
        time.sleep(0.5)
        assert page.evaluate(picture) != before


def test_after_five_seconds_of_standing_still_the_next_picture_is_the_present(chromium, address):
    with shown(chromium, address) as page:
        time.sleep(1.0)
        page.evaluate("{ const end = performance.now() + 5000; while (performance.now() < end); }")
        stood = page.evaluate("cohaptic.time")
        until(page, f"cohaptic.time > {stood} + 1")
        age = page.evaluate("cohaptic.age")
        stale = page.evaluate("cohaptic.stale")
        assert age < 100
        assert stale >= 1


def test_packets_ripple_and_deadlines_are_told(chromium, address):
    with shown(chromium, address) as page:
        until(page, "document.querySelector('[data-key=\"age-lan.forward\"]')")
        time.sleep(1.5)
        assert 7 < readout(page, "age-lan.forward") < 16
        assert readout(page, "loss-lan.forward") == 0
        assert readout(page, "ripple-b") < 0.2
        assert readout(page, "misses") is not None


def test_a_page_without_the_token_says_what_to_do(chromium, address):
    context = chromium.new_context()
    page = context.new_page()
    page.goto(address.partition("#")[0])
    page.locator("#state", has_text="Not let in").wait_for()
    assert "open the whole address that cohaptic printed" in page.inner_text("#state")
    context.close()


def test_a_run_without_a_pace_is_watched_too(chromium, tmp_path):
    words = ("--live", "--duration", "400", "--no-figure", "--out", str(tmp_path / "run"))
    watched = command("run", "two_users_box", *words)
    with watched as (address, _), shown(chromium, address) as page:
        assert until(page, "cohaptic.time > 20")
        assert colours(page) > 8
