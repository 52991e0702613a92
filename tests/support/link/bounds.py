"""What may never happen, whatever was done to the datagrams: checked in every station's record."""

from __future__ import annotations

import itertools

from tests.support.link.whole import RATE, Sample, World, position

SPEED, RANGE = 0.9, 0.1
"""Of the hands: m/s, m."""
HOLD, SAMPLE, FADE, RESUME = 4, 1, 7, 128
"""Ticks at 128 Hz: the hold, a sample, 50 ms, a second."""
LONGEST_WAY = 16
"""Samples that a packet may take where nothing else is said."""


def check_records(world: World) -> None:
    """Values are the peer's, and not too old; forces and their steps are bounded."""
    for station in world.everybody:
        for peer, samples in station.samples.items():
            assert station.remotes[peer].link.faulty == 0
            for sample in samples:
                assert abs(sample.force) <= 2.0 * RANGE
            for before, after in itertools.pairwise(samples):
                check_step(before, after)
            check_values(peer, samples)


def check_step(before: Sample, after: Sample) -> None:
    """In units of stiffness: what one tick may change."""
    rise, fall = after.weight - before.weight, before.weight - after.weight
    starts = before.weight == 0.0 and after.weight == 1.0
    assert starts or rise <= 1.001 / RESUME
    assert fall <= 1.001 / FADE
    if starts:
        return
    # Both hands move on; a packet more or less is as far as the hold reaches.
    moved = SPEED * (HOLD + SAMPLE + 1) / RATE
    own = SPEED * (after.true - before.true) * 1e-9
    assert abs(after.force - before.force) <= moved + own + max(fall, rise, 0.0) * 2.0 * RANGE


def check_values(peer: str, samples: list[Sample]) -> None:
    for sample in samples:
        if sample.weight == 0.0 or sample.sampled < 0:
            continue
        # The hand is where it is at true time; the value is one of the last so many samples.
        oldest = (LONGEST_WAY + HOLD + SAMPLE + FADE + 2) / RATE
        assert abs(sample.value - position(peer, sample.true)) <= SPEED * oldest
