"""Two real stations with an attacker between their sockets: no loop ends, everybody comes back."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from cosim.base.errors import InputError
from cosim.record import open_run
from tests.support.link.attacker import Attacker, Hardest
from tests.support.link.processes import NAMES, check_bounds, check_steps, link_of
from tests.support.link.real_world import TICK_NS, RealWorld, began, news_of_peer, peer_of
from tests.support.link.silences import BACK, closed_by, longest_silence, without
from tests.support.link.whole import MILLISECOND, SECOND
from tests.support.machine import timed

JOIN = BACK + 2500 * MILLISECOND + 1400 * MILLISECOND
"""Until somebody looks whether a session is dead, a start, and its ramp."""
LAST = 64 * MILLISECOND
"""Before the first of them ends."""
STALL = 0.015
"""A machine that wakes a process so late (s) keeps values back for as long as the hold lasts."""


def survive(attacker: Attacker, out: Path) -> bool | str:
    """One schedule; a sentence where the forces did not come back in time."""
    world = RealWorld(attacker, out)
    try:
        calm = world.run(JOIN + SECOND) - SECOND
        end = time.monotonic_ns() - LAST
        never = world.stop()
    finally:
        world.close()
    if never:
        return never
    closed = [(world.began + a, world.began + b) for a, b in closed_by(attacker)]
    spans = without([(max(map(began, world.folders.values())), end)], closed)
    for folder in world.records:
        # Who was killed before his first half second was written has no record.
        if folder in world.folders.values() or is_record(folder):
            check_bounds(folder, peer_of(folder))
            check_steps(folder, peer_of(folder))
    for folder in world.folders.values():
        name, peer = folder.name, peer_of(folder)
        assert link_of(folder)["peers"][peer]["faulty"] == 0
        assert link_of(folder)["handshake_process"]["absurd"] == 0
        silence = longest_silence(news_of_peer(folder), spans)
        if silence > BACK:
            return f"{name} heard nothing of its peer for {silence * 1e-9:.2f} s of an open way"
        first, last = (max(0, round((at - began(folder)) / TICK_NS)) for at in (calm, end))
        back = check_bounds(folder, peer)[first:last]
        assert len(back) > 256, f"{name} ended before it could come back"
        if back.min() < 1.0:
            return f"{name} saw its peer at {back.min():.3f} when both had been back"
    return True


def is_record(folder: Path) -> bool:
    try:
        with open_run(folder) as run:
            return run.ticks > 0
    except InputError:
        return False


def test_two_processes_survive_what_is_hardest(tmp_path) -> None:
    assert timed(
        lambda number: survive(Hardest(0, list(NAMES), way=MILLISECOND), tmp_path / str(number)),
        tolerates=STALL,
        attempts=4,
    )


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_two_processes_survive_a_drawn_schedule(tmp_path, seed: int) -> None:
    assert timed(
        lambda number: survive(
            Attacker(seed, list(NAMES), way=MILLISECOND), tmp_path / str(number)
        ),
        tolerates=STALL,
        attempts=4,
    )
