"""Direct multi-rate state space (4.12)–(4.24), Appendix A: several rates, any rational ratios.

A plant ẋ = A x + B w is driven by signals that are each sampled at their own period, a whole number of
base ticks, and held. The hyperperiod is lifted into one linear map by the block matrices of
Appendix A (Araki and Yamamoto's realisation), and the feedback closed as in (4.30).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cosim.theory.numerics import Real
from cosim.theory.zero_order_hold import zero_order_hold


@dataclass(frozen=True, slots=True)
class Signal:
    """A value that is computed every ``period`` base ticks and held from ``delay`` samples later.

    Attributes:
        period: base ticks.
        state: row over the plant's state, shape (n,).
        others: gain on what each other signal holds at that instant, by signal number.
        force: what 1 N of it does to ẋ, shape (n,), or None where it drives nothing.
        delay: in samples of its own period.
    """

    period: int
    state: Real
    others: dict[int, float] = field(default_factory=dict[int, float])
    force: Real | None = None
    delay: int = 0


@dataclass(frozen=True, slots=True)
class Lifted:
    """The closed loop over one hyperperiod, z⁺ = M z + b f with f held throughout.

    The state z is the plant's state, then each signal's last samples, newest first.

    Attributes:
        map: shape (n, n).
        force: shape (n,), effect of the constant external force.
        memory: where each signal's past samples begin in z.
    """

    map: Real
    force: Real
    memory: tuple[int, ...]


def state_blocks(A: Real, tick: float, ticks: int) -> Real:
    """A_D1 … A_DN of (A.2), e^{A l τ₀} for l = 1 … N.

    Returns:
        Shape (ticks, n, n).
    """
    empty = np.zeros((A.shape[0], 0))
    return np.array([zero_order_hold(A, empty, tick * (l + 1))[0] for l in range(ticks)])


def input_blocks(A: Real, b: Real, period: int, tick: float, ticks: int) -> Real:
    """B_Di of (A.4)–(A.5): effect of sample μ of an input on the state at tick l.

    Args:
        A: shape (n, n).
        b: shape (n,).
        period: the input's period in base ticks.
        tick: τ₀ in s.
        ticks: ticks per hyperperiod.

    Returns:
        Shape (ticks, samples, n), row l − 1 for the state at tick l.
    """
    samples = ticks // period
    blocks = np.zeros((ticks, samples, b.size))
    for l in range(1, ticks + 1):
        for mu in range(samples):
            start, stop = mu * period, min((mu + 1) * period, l)
            if stop <= start:
                continue
            # ∫ from start to stop of e^{A(lτ₀ − τ)} b dτ = e^{A(l − stop)τ₀} ∫₀ e^{Aη} dη b.
            held = zero_order_hold(A, b[:, None], (stop - start) * tick)[1]
            later = zero_order_hold(A, b[:, None], (l - stop) * tick)[0]
            blocks[l - 1, mu] = (later @ held)[:, 0]
    return blocks


def lift(
    A: Real, signals: Sequence[Signal], tick: float, external: Real | None = None
) -> Lifted:
    """Lift the sampled loop over the least common multiple of its periods.

    Args:
        A: the plant, shape (n, n).
        signals: at most one hyperperiod's worth of instants each; they may read each other within
            an instant, but not in a circle.
        tick: the base tick τ₀ in s.
        external: what an external constant 1 N does to ẋ, shape (n,).
    """
    n = A.shape[0]
    ticks = math.lcm(*(signal.period for signal in signals))
    counts = [ticks // signal.period for signal in signals]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    total = int(first[-1])
    memory_start = np.concatenate([[n], n + np.cumsum([s.delay for s in signals])]).astype(int)
    size = int(memory_start[-1])

    powers = np.concatenate([np.eye(n)[None], state_blocks(A, tick, ticks)])
    push = np.zeros((ticks + 1, n, total))
    for number, signal in enumerate(signals):
        if signal.force is not None:
            blocks = input_blocks(A, signal.force, signal.period, tick, ticks)
            push[1:, :, first[number] : first[number + 1]] = blocks.transpose(0, 2, 1)
    constant = np.zeros((ticks + 1, n))
    if external is not None:
        for l in range(1, ticks + 1):
            constant[l] = zero_order_hold(A, external[:, None], l * tick)[1][:, 0]

    # raw = X x₀ + Y held + c f;  held = S raw + Z z (delays shift whole samples, (4.21)).
    X = np.zeros((total, size))
    Y = np.zeros((total, total))
    c = np.zeros(total)
    S = np.zeros((total, total))
    Z = np.zeros((total, size))
    for number, signal in enumerate(signals):
        for mu in range(counts[number]):
            row, now = int(first[number]) + mu, mu * signal.period
            X[row, :n] = signal.state @ powers[now]
            Y[row] = signal.state @ push[now]
            c[row] = float(signal.state @ constant[now])
            for other, gain in signal.others.items():
                Y[row, int(first[other]) + now // signals[other].period] += gain
            source = mu - signal.delay
            if source >= 0:
                S[row, int(first[number]) + source] = 1.0
            else:
                Z[row, int(memory_start[number]) - source - 1] = 1.0
    solve = np.linalg.inv(np.eye(total) - Y @ S)
    raw, raw_force = solve @ (X + Y @ Z), solve @ c
    held, held_force = S @ raw + Z, S @ raw_force

    M = np.zeros((size, size))
    b = np.zeros(size)
    M[:n, :n] = powers[ticks]
    M[:n] += push[ticks] @ held
    b[:n] = constant[ticks] + push[ticks] @ held_force
    for number, signal in enumerate(signals):
        for age in range(signal.delay):
            place, source = int(memory_start[number]) + age, counts[number] - 1 - age
            if source >= 0:
                M[place] = raw[int(first[number]) + source]
                b[place] = raw_force[int(first[number]) + source]
            else:
                M[place, int(memory_start[number]) - source - 1] = 1.0
    return Lifted(map=M, force=b, memory=tuple(int(v) for v in memory_start[:-1]))
