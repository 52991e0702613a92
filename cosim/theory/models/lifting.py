"""Direct multi-rate state space (4.12)–(4.24), Appendix A: several rates, any rational ratios.

A plant ẋ = A x + B w is driven by signals that are each sampled at their own period, a whole number
of base ticks, and held. The hyperperiod is lifted into one linear map by the block matrices of
Appendix A (Araki and Yamamoto's realisation), and the feedback closed as in (4.30).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from cosim.theory.models.zero_order_hold import zero_order_hold
from cosim.theory.numerics import Real


@dataclass(frozen=True, slots=True)
class LiftedSignal:
    """A value that is computed every ``period`` base ticks and held from ``delay`` samples later.

    Attributes:
        period: base ticks.
        state: row over the plant's state, shape (n,).
        others: gain on what each other signal holds at that instant, by signal number.
        force: what 1 N of it does to ẋ, shape (n,), or None where it drives nothing.
        delay: in samples of its own period.
        known: base ticks; it is what was so at the last multiple of them, 0: right then.
    """

    period: int
    state: Real
    others: dict[int, float] = field(default_factory=dict[int, float])
    force: Real | None = None
    delay: int = 0
    known: int = 0

    def seen(self, tick: int) -> int:
        """The base tick of which the value computed at ``tick`` is."""
        return tick // self.known * self.known if self.known else tick


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


def exponentials(A: Real, tick: float, ticks: int) -> tuple[Real, Real]:
    """What every block of Appendix A is made of, for l = 0 … N.

    Returns:
        e^{A l τ₀} (A.2) and ∫₀^{l τ₀} e^{Aη} dη, both of shape (ticks + 1, n, n).
    """
    pairs = [zero_order_hold(A, np.eye(A.shape[0]), at * tick) for at in range(ticks + 1)]
    return np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs])


def input_blocks(powers: Real, integrals: Real, b: Real, period: int) -> Real:
    """B_Di of (A.4)–(A.5): effect of sample μ of an input on the state at tick l.

    Args:
        powers: e^{A l τ₀}, shape (ticks + 1, n, n).
        integrals: ∫₀^{l τ₀} e^{Aη} dη, shape (ticks + 1, n, n).
        b: the input's column, shape (n,).
        period: the input's period in base ticks.

    Returns:
        Shape (ticks + 1, n, samples).
    """
    ticks = powers.shape[0] - 1
    blocks = np.zeros((ticks + 1, b.size, ticks // period))
    for at in range(1, ticks + 1):
        for mu in range(-(-at // period)):
            start, stop = mu * period, min((mu + 1) * period, at)
            # ∫ from start to stop of e^{A(lτ₀ − τ)} b dτ = e^{A(l − stop)τ₀} ∫₀ e^{Aη} dη b.
            blocks[at, :, mu] = powers[at - stop] @ (integrals[stop - start] @ b)
    return blocks


def lift(
    A: Real,
    signals: Sequence[LiftedSignal],
    tick: float,
    external: Real | None = None,
    ticks: int | None = None,
) -> Lifted:
    """Lift the sampled loop over a common multiple of its periods.

    Args:
        A: the plant, shape (n, n).
        signals: at most one hyperperiod's worth of instants each; they may read each other within
            an instant, but not in a circle.
        tick: the base tick τ₀ in s.
        external: what an external constant 1 N does to ẋ, shape (n,).
        ticks: how many base ticks to lift, a multiple of every period; None: the least.
    """
    n = A.shape[0]
    if ticks is None:
        ticks = math.lcm(*(signal.period for signal in signals))
    counts = [ticks // signal.period for signal in signals]
    first = np.concatenate([[0], np.cumsum(counts)]).astype(int)
    total = int(first[-1])
    memory_start = np.concatenate([[n], n + np.cumsum([s.delay for s in signals])]).astype(int)
    size = int(memory_start[-1])

    powers, integrals = exponentials(A, tick, ticks)
    push = np.zeros((ticks + 1, n, total))
    for number, signal in enumerate(signals):
        if signal.force is not None:
            columns = slice(int(first[number]), int(first[number + 1]))
            push[:, :, columns] = input_blocks(powers, integrals, signal.force, signal.period)
    constant = np.zeros((ticks + 1, n)) if external is None else integrals @ external

    # raw = X x₀ + Y held + c f;  held = S raw + Z z (delays shift whole samples, (4.21)).
    X = np.zeros((total, size))
    Y = np.zeros((total, total))
    c = np.zeros(total)
    S = np.zeros((total, total))
    Z = np.zeros((total, size))
    for number, signal in enumerate(signals):
        for mu in range(counts[number]):
            row, now = int(first[number]) + mu, signal.seen(mu * signal.period)
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
