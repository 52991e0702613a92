"""Who watches and who records never holds up the loop: seen on the wire, by the motors."""

from __future__ import annotations

import json
import time
from itertools import pairwise
from pathlib import Path

from tests.support.hil.ending_table import STALL, check_every_tick
from tests.support.hil.endings import Run
from tests.support.machine import timed

SECONDS = 4.0
"""Longer than a command that is stopped would be let be."""
LONGEST_GAP = 0.008
"""Between two commands on the wire (s)."""
SLOW = """
import time
from cosim.realtime import relay
relay.SECONDS = 1.0
pump, begun = relay.RelayPump.pump, time.monotonic() + 3600.0
def slow(self):
    global begun
    if self._rows[0] > 1500 and begun > time.monotonic():
        begun = time.monotonic()
        time.sleep(4.0)
    return pump(self)
relay.RelayPump.pump = slow
"""


def steady(run: Run, begin: float, end: float) -> None:
    """It went on pushing, tick by tick, all that time."""
    seen = run.seen()
    times = [t for t, *_ in seen.torques if begin <= t <= end]
    assert len(times) > 0.9 * 1024 * SECONDS, f"{len(times)} commands: {run.said}"
    worst, at = max((after - before, before) for before, after in pairwise(times))
    assert worst < LONGEST_GAP + seen.busy(at - LONGEST_GAP, worst), run.said
    assert seen.pushes(end), run.said
    check_every_tick(seen.torques)


def test_a_frozen_terminal(tmp_path: Path):
    def attempt(number: int) -> str | None:
        folder = tmp_path / str(number)
        folder.mkdir()
        run = Run(folder, "cobs")
        try:
            run.start()
            run.type("\x13")
            begin = time.monotonic()
            time.sleep(SECONDS)
            end = time.monotonic()
            run.type("\x11")
            run.type("\x03")
            assert run.status() == 1, run.said
            assert "Interrupted" in run.said, run.said
            assert "output unknown" not in run.said, run.said
            steady(run, begin, end)
        except AssertionError as error:
            return str(error)
        finally:
            run.end()
        return None

    timed(attempt, tolerates=STALL)


def test_a_recorder_that_takes_seconds(tmp_path: Path):
    def attempt(number: int) -> str | None:
        folder = tmp_path / str(number)
        folder.mkdir()
        run = Run(folder, "cobs", first=SLOW)
        try:
            run.start()
            time.sleep(1.0)
            begin = time.monotonic()
            time.sleep(SECONDS + 1.5)
            end = time.monotonic()
            run.type("\x03")
            assert run.status() == 1, run.said
            steady(run, begin, end)
            manifest = json.loads((folder / "out" / "manifest.json").read_text())
            lost = manifest["deadlines"]["lost_rows"]
            assert 1000 < lost < 6000, run.said
            assert f"too slow for {lost} rows" in run.said
        except AssertionError as error:
            return str(error)
        finally:
            run.end()
        return None

    timed(attempt, tolerates=STALL)
