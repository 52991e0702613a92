"""From a pointer's event to the canvas drawn with it, measured by the page, which says how."""

from __future__ import annotations

import math
import time

import pytest

from tests.browser.conftest import command, shown, until
from tests.browser.test_people_carry_a_box import place
from tests.support.machine import timed
from tests.support.others import others_probe

pytestmark = pytest.mark.browser

MEDIAN, MOST = 50.0, 150.0
"""Milliseconds that half and 99 of 100 events may take on two processors. A virtual machine that
took 11 and 37 at one time took 35 and 93 at another, with one program and nothing else to do."""
EVENTS = 200
TOLERATED = 0.1
"""Processors that others may take, while a failure counts."""
ATTEMPTS = 5
"""Each takes some ten seconds; with three faults among them it has failed."""


def test_half_within_50_ms_and_99_of_100_within_150(chromium, tmp_path):
    words = ("play", "--no-browser", "--out", str(tmp_path / "take"))
    with command(*words) as (address, _):

        def attempt(_: int):
            with shown(chromium, address, 700) as page:
                until(page, "cohaptic.run.scene.pointers.length === 2")
                until(page, "document.getElementById('user').value === 'station_a'")
                time.sleep(1.0)
                for step in range(EVENTS):
                    turn = step / 40
                    page.mouse.move(*place(page, 30 * math.cos(turn), 30 * math.sin(turn)))
                until(page, "!document.getElementById('how').hidden")
                half, most = page.evaluate("[0.5, 0.99].map((share) => cohaptic.latency(share))")
                measured = page.evaluate("cohaptic.measured")
                assert "from the time that the browser" in page.inner_text("#how")
            figures = f"of {measured} events half within {half:.0f} ms, 99 % within {most:.0f} ms"
            print(figures)
            assert measured > EVENTS / 2, "the page has measured too few of the events"
            return (half, most) if half <= MEDIAN and most <= MOST else figures

        assert timed(attempt, tolerates=TOLERATED, attempts=ATTEMPTS, probing=others_probe)
