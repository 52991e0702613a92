"""Z-width: the stiffest wall that a device renders, by rule, by eigenvalues, and as it is built.

By rule (Gil, Sánchez, Hulin, Preusche and Hirzinger 2009): K < (b + B) / (T/2 + t_d), b being the
device's physical damping, B the wall's, t_d the delay. By eigenvalues: exact for a mass under a
held force with its true velocity. As it is built: positions in encoder counts and velocities by
first-order adaptive windowing (Janabi-Sharifi, Hayward and Chen 2000), simulated.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.zero_order_hold import zero_order_hold
from cosim.theory.numerics import Bool, Real, spectral_radius

SETTLED_COUNTS = 8.0
"""Encoder counts between whose extremes a mass that has come to rest may still flicker."""
LOOKED = (0.5, 1.0)
"""A simulated trial, s: from here on the extremes are noted, and from here on noted anew, to its
end as long after; it rests where the latter are nearer than ``CALMER`` times the former."""
CALMER = 0.8
PUSH = 0.005
"""m, from which the wall lets the mass go; many counts, so that what is linear shows."""


@dataclass(frozen=True, slots=True)
class RenderedWall:
    """A device, its sampling and its encoder: what renders the wall.

    Attributes:
        mass: kg.
        damping: b, physical, N·s/m.
        period: T in s.
        delay: t_d, whole ticks from measurement to force.
        count: m of position to an encoder count; 0 for none.
        window: most ticks of the velocity's window; 0 for the true velocity.
    """

    mass: float
    damping: float
    period: float
    delay: int = 0
    count: float = 0.0
    window: int = 0

    def __post_init__(self) -> None:
        """Refuse what is no device.

        Raises:
            InputError: a number is out of its range.
        """
        if not (self.mass > 0 and self.damping >= 0 and self.period > 0):
            raise InputError("A device has a positive mass and period, and no negative damping.")
        if self.delay < 0 or self.count < 0 or not 0 <= self.window <= 64:
            raise InputError(
                "A delay is 0 ticks or more, a count 0 m or more, a window 0 to 64 ticks."
            )


def by_rule(device: RenderedWall, damping: float) -> float:
    """(b + B) / (T/2 + t_d), N/m."""
    return (device.damping + damping) / (device.period * (0.5 + device.delay))


def by_eigenvalues(device: RenderedWall, damping: float) -> float:
    """The largest K up to which the sampled wall is stable, N/m; 0 where none is."""

    def stable(stiffness: float) -> bool:
        return spectral_radius(_map(device, stiffness, damping)) < 1.0

    return _largest(stable, by_rule(device, damping))


def as_built(device: RenderedWall, damping: Real, levels: int = 24) -> Real:
    """The largest K at which a simulated trial comes to rest, N/m, shape of ``damping``.

    All walls are tried at once, ``levels`` of stiffness to each damping, evenly in the logarithm
    from a fiftieth of the rule's to its double; the answer is the last below the first that does
    not rest, 0 where the softest does not.
    """
    factors = np.geomspace(0.02, 2.0, levels)
    limits = np.array([by_rule(device, float(one)) for one in damping])
    stiffness = limits[:, None] * factors[None, :]
    walls = np.broadcast_to(damping[:, None], stiffness.shape)
    rests = _rests(device, stiffness.ravel(), walls.ravel()).reshape(stiffness.shape)
    first = np.where(rests.all(axis=1), levels, np.argmin(rests, axis=1))
    rows = np.arange(len(damping))
    return np.where(first > 0, stiffness[rows, np.maximum(first - 1, 0)], 0.0)


def stiffest(
    device: RenderedWall,
    damping: Sequence[float],
    rests: Callable[[float, float], bool],
    levels: int = 24,
) -> Real:
    """The same where every trial is a run of its own, the softest first.

    Args:
        device: whose rule says where to look.
        damping: of the walls, N·s/m.
        rests: whether a trial with a stiffness and a damping comes to rest.
        levels: of stiffness to each damping.
    """
    found = np.zeros(len(damping))
    for place, one in enumerate(damping):
        for factor in np.geomspace(0.02, 2.0, levels):
            stiffness = by_rule(device, one) * float(factor)
            if not rests(stiffness, one):
                break
            found[place] = stiffness
    return found


def _rests(device: RenderedWall, stiffness: Real, damping: Real) -> Bool:
    """Which walls bring the mass to rest, shape (walls,)."""
    lanes = stiffness.size
    F, G = _free(device)
    position, velocity = np.full(lanes, PUSH), np.zeros(lanes)
    measured = _counted(position, device.count)
    history = np.tile(measured, (max(device.window, 1) + 1, 1))
    late = [np.zeros(lanes) for _ in range(device.delay)]
    seen = np.zeros((_marks(device.period)[2], lanes))
    for tick in range(len(seen)):
        measured = _counted(position, device.count)
        history = np.roll(history, 1, axis=0)
        history[0] = measured
        speed = velocity if device.window == 0 else _windowed(history, device)
        late.append(-stiffness * measured - damping * speed)
        force = late.pop(0)
        position, velocity = (
            F[0, 0] * position + F[0, 1] * velocity + G[0] * force,
            F[1, 0] * position + F[1, 1] * velocity + G[1] * force,
        )
        # What has run away stays away.
        position = np.clip(position, -1.0, 1.0)
        seen[tick] = position
    return comes_to_rest(seen, device.period, device.count)


def comes_to_rest(seen: Real, period: float, count: float) -> Bool:
    """Which trials come to rest, or nearer to it each half second, shape (lanes,).

    Args:
        seen: positions, shape (ticks, lanes), m.
        period: of a tick, s.
        count: of the encoder, m.
    """
    first, second, last = _marks(period)
    before, after = (np.ptp(one, axis=0) for one in (seen[first:second], seen[second:last]))
    return (after <= max(SETTLED_COUNTS * count, 1e-9)) | (after < CALMER * before)


def _marks(period: float) -> tuple[int, int, int]:
    first, second, last = (
        round(seconds / period) for seconds in (*LOOKED, 2 * LOOKED[1] - LOOKED[0])
    )
    return first, second, last


def _windowed(history: Real, device: RenderedWall) -> Real:
    """Velocity over the longest window whose chord passes all its samples within a count.

    Args:
        history: counted positions, newest first, shape (window + 1, lanes).
        device: its window and count.
    """
    found: Real = (history[0] - history[1]) / device.period
    holds = np.ones(found.shape, dtype=bool)
    for length in range(2, device.window + 1):
        slope = (history[0] - history[length]) / length
        steps = np.arange(1, length)[:, None]
        off = np.abs(history[0] - slope * steps - history[1:length])
        holds &= np.all(off <= device.count * (1 + 1e-9), axis=0)
        found[holds] = slope[holds] / device.period
    return found


def _counted(position: Real, count: float) -> Real:
    return position if count == 0.0 else np.round(position / count) * count


def _free(device: RenderedWall) -> tuple[Real, Real]:
    F, G = zero_order_hold(
        np.array([[0.0, 1.0], [0.0, -device.damping / device.mass]]),
        np.array([[0.0], [1.0 / device.mass]]),
        device.period,
    )
    return F, G[:, 0]


def _map(device: RenderedWall, stiffness: float, damping: float) -> Real:
    """One tick of (x, v, forces on their way), newest force first."""
    F, G = _free(device)
    size = 2 + device.delay
    found = np.zeros((size, size))
    found[:2, :2] = F
    law = np.array([-stiffness, -damping])
    if device.delay == 0:
        found[:2, :2] += np.outer(G, law)
        return found
    found[:2, -1] = G
    found[2, :2] = law
    found[3:, 2:-1] = np.eye(device.delay - 1)
    return found


def _largest(stable: Callable[[float], bool], near: float) -> float:
    grid = near * np.geomspace(1e-4, 4.0, 400)
    last = 0.0
    for value in grid:
        if stable(float(value)):
            last = float(value)
        elif last > 0.0:
            low, high = last, float(value)
            for _ in range(60):
                middle = (low + high) / 2.0
                low, high = (middle, high) if stable(middle) else (low, middle)
            return low
    return last
