"""A network measurement whose packets are given as arrays."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import numpy as np

from cosim.link.netchar.measurement import KEPT, WINDOW, NetworkMeasurement


def measured(
    rate: float,
    sent: np.ndarray,
    returned: np.ndarray,
    received: np.ndarray,
    relayed: np.ndarray,
    *,
    counts: dict[int, int] | None = None,
    window: int = WINDOW,
    kept: int = KEPT,
) -> NetworkMeasurement:
    """Times (ns) of shape (packets,), 0 where nothing came back; ``counts`` as the relay tells."""
    result = NetworkMeasurement(rate, 100, window=window, kept=kept)
    events = [(int(now), 1, number) for number, now in enumerate(sent)]
    events += [(int(at), 0, number) for number, at in enumerate(returned) if at]
    for now, leaves, number in sorted(events):
        if leaves:
            result.sent(now)
            continue
        count = number + 1 if counts is None else counts[number]
        there = int(received[number]), int(relayed[number])
        result.reply(int(sent[number]), *there, now, count)
    result.end()
    return result


def peak(work: Callable[[], object]) -> int:
    """Bytes that ``work`` had at most at one time."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
