"""The highest packet rate that a network carries: Table 1.1's "achievable packet rate"."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cosim.link.netchar.measurement import RETURNED, SENT, NetworkMeasurement

Run = Callable[[float], NetworkMeasurement]


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One rate that was tried."""

    rate: float
    sent_rate: float
    loss: float
    carried: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class RateSearch:
    """``achievable`` packets a second were carried, ``limit`` says what stopped the next step."""

    achievable: float
    limit: str
    trials: list[Trial]


def search_rate(
    run: Run, *, lowest: float = 128.0, highest: float = 16_384.0, loss: float = 0.005
) -> RateSearch:
    """Double the rate until it is not carried, then halve the gap until it is below a tenth.

    Carried means: at most ``loss`` lost, sent in time, and no queue that grows while it runs (the
    second half's median round trip at most 1.5 times the first half's plus 1 ms).
    """
    trials: list[Trial] = []
    limit = "the highest rate that was tried"

    def carried(rate: float) -> bool:
        nonlocal limit
        measurement = run(rate)
        trial, why = _judge(rate, measurement, loss)
        trials.append(trial)
        if why:
            limit = why
        return trial.carried

    good, bad, rate = 0.0, None, lowest
    while bad is None and rate <= highest:
        if carried(rate):
            good, rate = rate, min(rate * 2.0, highest) if rate < highest else rate * 2.0
        else:
            bad = rate
    while bad is not None and good > 0.0 and bad / good > 1.1:
        middle = (good * bad) ** 0.5
        if carried(middle):
            good = middle
        else:
            bad = middle
    return RateSearch(achievable=good, limit=limit, trials=trials)


def _judge(rate: float, measurement: NetworkMeasurement, loss: float) -> tuple[Trial, str]:
    span = (measurement.last_sent - measurement.first_sent) * 1e-9
    sent = measurement.count - measurement.unsent
    sent_rate = (sent - 1) / span if span > 0.0 else rate
    lost = (measurement.lost - measurement.capped) / max(1, measurement.count)
    why = ""
    if sent_rate < 0.95 * rate:
        why = f"this computer sent {sent_rate:.0f} of {rate:.0f} packets a second"
    elif measurement.capped:
        why = f"the relay's own cap (--max-rate) is below {rate:.0f} packets a second"
    elif lost > loss:
        why = f"{100.0 * lost:.2g} % were lost at {rate:.0f} packets a second"
    elif measurement.returned >= 20:
        columns = measurement.kept.columns
        columns = columns[:, columns[RETURNED] > 0]
        trips = (columns[RETURNED] - columns[SENT]).astype(np.float64)
        half = len(trips) // 2
        first, second = float(np.median(trips[:half])), float(np.median(trips[half:]))
        if second > 1.5 * first + 1e6:
            why = f"a queue grew at {rate:.0f} packets a second"
    return Trial(rate=rate, sent_rate=sent_rate, loss=lost, carried=not why), why
