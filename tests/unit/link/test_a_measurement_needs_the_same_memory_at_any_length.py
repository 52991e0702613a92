"""netchar counts every packet and keeps a bounded number: a day fits where a second does."""

from __future__ import annotations

import random
from collections import Counter
from itertools import groupby

import numpy as np
import pytest

from cosim.link.netchar.bursts import LossPattern
from cosim.link.netchar.measurement import (
    RETURNED,
    SENT,
    EchoKind,
    KeptTimes,
    NetworkMeasurement,
)
from cosim.link.netchar.statistics import characterise
from tests.support.link.measured import measured, peak


def test_memory_does_not_grow_with_the_packets() -> None:
    def run(count: int):
        def work() -> None:
            measurement = NetworkMeasurement(1000.0, 280, window=256, kept=1024)
            for number in range(1, count):
                measurement.sent(number * 1000)
                if number % 7:
                    measurement.reply(number * 1000, 1, 1, number * 1000 + 500, number)
            measurement.end()
            assert measurement.count == count - 1
            characterise(measurement)

        return work

    run(100)()
    assert peak(run(32_000)) < peak(run(4_000)) + 10_000


def journey(count: int, seed: int):
    """Times of packets of which some are lost in bursts and some overtaken."""
    draw = np.random.default_rng(seed)
    sent = np.arange(1, count + 1) * 1_000_000
    there, back = draw.exponential(3e6, count).astype(np.int64), draw.integers(1, 10**6, count)
    received = sent + 5_000_000 + there
    returned = received + 2_000_000 + back
    bad = np.repeat(draw.random(count // 4 + 1) < 0.1, 4)[:count]
    lost = bad & (draw.random(count) < 0.8)
    for times in (received, returned):
        times[lost] = 0
    return sent, returned, received


def test_a_long_measurement_says_what_a_wholly_kept_one_does() -> None:
    """Counts to the packet; the quantiles to what a sample of the kept size can say."""
    sent, returned, received = journey(60_000, 3)
    whole = characterise(measured(1000.0, sent, returned, received, received))
    thin = characterise(measured(1000.0, sent, returned, received, received, window=128, kept=8192))
    assert thin.kept_one_in == 8
    assert whole.kept_one_in == 1
    for name in ("sent", "returned", "reordered", "duplicates", "late", "loss", "duration"):
        assert getattr(thin, name) == getattr(whole, name), name
    assert whole.round_trip is not None
    assert thin.round_trip is not None
    assert thin.round_trip.maximum == whole.round_trip.maximum
    assert thin.round_trip.minimum == whole.round_trip.minimum
    assert thin.round_trip.mean == pytest.approx(whole.round_trip.mean, rel=0.02)
    assert thin.round_trip.rms_jitter == pytest.approx(whole.round_trip.rms_jitter, rel=0.05)
    assert thin.round_trip.percentiles["99"] == pytest.approx(
        whole.round_trip.percentiles["99"], rel=0.1
    )


@pytest.mark.parametrize("seed", range(5))
def test_losses_added_in_pieces_are_those_added_at_once(seed: int) -> None:
    draw = random.Random(seed)
    lost = np.array([draw.random() < draw.choice((0.05, 0.9)) for _ in range(3000)])
    whole, pieces = LossPattern(), LossPattern()
    whole.add(lost)
    at = 0
    while at < len(lost):
        step = draw.choice((0, 1, 2, 3, 50))
        pieces.add(lost[at : at + step])
        at += step
    expected = Counter(len(list(run)) for value, run in groupby(lost.tolist()) if value)
    for found in (whole, pieces):
        assert found.bursts == dict(sorted(expected.items()))
        assert found.losses == lost.sum()
        assert found.pairs == np.sum(lost[1:] & lost[:-1])
        assert found.ends == np.sum(lost[2:] & lost[:-2])
        assert found.triples == np.sum(lost[2:] & lost[1:-1] & lost[:-2])


def test_one_packet_of_each_stretch_is_kept_and_none_in_step() -> None:
    kept = KeptTimes(64)
    columns = np.zeros((4, 5000), dtype=np.int64)
    columns[SENT] = np.arange(5000)
    for start in range(0, 5000, 37):
        kept.add(columns[:, start : start + 37])
    assert kept.stride == 128
    numbers = kept.columns[SENT]
    assert np.array_equal(numbers // 128, np.arange(len(numbers)))
    assert len(set(numbers % 128)) > len(numbers) // 2


def test_a_reply_after_its_packet_was_given_up_is_late_and_not_lost() -> None:
    measurement = NetworkMeasurement(100.0, 280, window=10)
    for number in range(1, 31):
        measurement.sent(number * 1000)
        if number > 5:
            assert (
                measurement.reply(number * 1000, 1, 1, number * 1000 + 1, number) is EchoKind.FIRST
            )
    for number in (1, 2, 3):
        assert measurement.reply(number * 1000, 1, 1, 40_000, 40 + number) is EchoKind.LATE
    measurement.end()
    found = characterise(measurement)
    assert (found.sent, found.returned, found.late, found.loss.packets) == (30, 25, 3, 2)
    assert np.sum(measurement.kept.columns[RETURNED] == 0) == 5
