"""Direct lifting of a loop with three rates and delays equals its simulation, base tick by tick."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from cosim.theory.models.lifting import LiftedSignal, lift

TICK = 1e-3


def simulated(A: np.ndarray, signals: list[LiftedSignal], force: np.ndarray) -> np.ndarray:
    """The map of one hyperperiod with its constant force, column by column, by expm and a loop."""
    n = A.shape[0]
    ticks = math.lcm(*(signal.period for signal in signals))
    size = n + sum(signal.delay for signal in signals)

    def run(start: np.ndarray, push: float) -> np.ndarray:
        x, rest = start[:n].copy(), start[n:]
        lines: list[list[float]] = []
        for signal in signals:
            lines.append(list(rest[: signal.delay]))
            rest = rest[signal.delay :]
        held = [0.0] * len(signals)
        for now in range(ticks):
            for number, signal in enumerate(signals):
                if now % signal.period == 0:
                    fresh = float(signal.state @ x)
                    fresh += sum(gain * held[other] for other, gain in signal.others.items())
                    lines[number].insert(0, fresh)
                    held[number] = lines[number].pop() if signal.delay else fresh
                    if not signal.delay:
                        lines[number].clear()
            w = push * force
            for value, signal in zip(held, signals, strict=True):
                if signal.force is not None:
                    w = w + value * signal.force
            block = np.zeros((n + 1, n + 1))
            block[:n, :n], block[:n, n] = A, w
            x = (expm(block * TICK) @ np.append(x, 1.0))[:n]
        return np.concatenate([x, *(np.array(line) for line in lines)])

    columns = [run(column, 0.0) for column in np.eye(size)]
    return np.column_stack([*columns, run(np.zeros(size), 1.0)])


@settings(deadline=None, max_examples=20)
@given(
    st.lists(st.integers(1, 5), min_size=3, max_size=3),
    st.lists(st.integers(0, 3), min_size=3, max_size=3),
    st.integers(0, 2**32 - 1),
)
def test_three_rates_with_delays(periods: list[int], delays: list[int], seed: int) -> None:
    rng = np.random.default_rng(seed)
    n = 4
    A = rng.normal(size=(n, n)) * 20
    signals = [
        LiftedSignal(periods[0], rng.normal(size=n), {}, rng.normal(size=n) * 50, delays[0]),
        LiftedSignal(periods[1], rng.normal(size=n), {0: 0.7}, None, delays[1]),
        LiftedSignal(
            periods[2], rng.normal(size=n), {0: -0.4, 1: 1.3}, rng.normal(size=n) * 50, delays[2]
        ),
    ]
    force = rng.normal(size=n)
    found = lift(A, signals, TICK, force)
    expected = simulated(A, signals, force)
    assert np.allclose(np.column_stack([found.map, found.force]), expected, rtol=1e-9, atol=1e-10)
