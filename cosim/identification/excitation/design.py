"""The trajectory for one device: as much motion as its limits let, where the interval is smallest.

For each extent of the slow part the fast part is made as large as every limit allows; of these the
one is taken whose regressor tells the inertia best, for encoders that count in ``quantum``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from cosim.base.errors import InputError
from cosim.identification.excitation.envelope import Envelope
from cosim.identification.excitation.trajectory import Trajectory
from cosim.identification.five_bar import Array
from cosim.identification.regressor import INERTIAS, torques

EXTENTS = (0.45, 0.35, 0.25, 0.15)
"""Peaks of the slow part that are tried (rad)."""
LEAST_FAST = 20.0
"""A fast part below this (rad/s2) drowns in friction and counts."""
LARGEST_FAST = 1000.0
_TICK = 1 / 256


def design(
    envelope: Envelope, values: Array, home: tuple[float, float], seconds: float, seed: int = 1
) -> Trajectory:
    """The trajectory for a device with these limits, at first taken to be ``values``.

    Args:
        envelope: what it may do.
        values: the regressor's parameters, payload included.
        home: joint angles (rad) where the handle is held at the start.
        seconds: how long it excites.
        seed: of the sines' phases.

    Raises:
        InputError: the limits leave no trajectory, or the way there does not lie inside.
    """
    best: tuple[float, Trajectory] | None = None
    refused = "the workspace leaves no room for 0.15 rad about any pose"
    for middle in _middles(envelope, home):
        for extent in EXTENTS:
            found = _fastest(
                envelope,
                values,
                Trajectory(middle=middle, slow=extent, fast=0.0, seconds=seconds, seed=seed),
                np.asarray(home),
            )
            if isinstance(found, str):
                refused = found or refused
                continue
            score = _spread(envelope, values, found)
            if best is None or score < best[0]:
                best = score, found
    if best is None:
        raise InputError(
            f"no excitation stays inside the limits of the device file: {refused}. Give the "
            "handle's home pose in the middle of the workspace, or tighten these limits less."
        )
    return best[1]


def _middles(envelope: Envelope, home: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """The home pose, and the middle of the workspace."""
    left, right, bottom, top = envelope.region
    yield home
    centre = np.array([[(left + right) / 2, (bottom + top) / 2]])
    turned = _same_turn(envelope.bar.angles(centre)[0], home)
    if np.all(np.isfinite(turned)):
        yield turned


def _same_turn(pose: Array, home: tuple[float, float]) -> tuple[float, float]:
    """A pose within half a turn of the home pose, which may be written with whole turns."""
    turns = np.round((np.asarray(home) - pose) / (2 * np.pi))
    turned: Array = pose + 2 * np.pi * turns
    return float(turned[0]), float(turned[1])


def _fastest(envelope: Envelope, values: Array, slow: Trajectory, home: Array) -> Trajectory | str:
    """With the largest fast part that the limits let; else what stands against it."""
    low, high = LEAST_FAST, LARGEST_FAST
    against = _against(envelope, values, replace(slow, fast=low), home)
    if against is not None:
        return against
    while high - low > 20.0:
        fast = (low + high) / 2
        inside = _against(envelope, values, replace(slow, fast=fast), home) is None
        low, high = (fast, high) if inside else (low, fast)
    return replace(slow, fast=low)


def _against(envelope: Envelope, values: Array, trajectory: Trajectory, home: Array) -> str | None:
    """Which limit a trajectory does not keep, or ``None``."""
    motion = trajectory.sampled(home, _TICK)
    if not envelope.keeps_inside(motion[0]):
        return ""
    use = envelope.use(motion, values, _TICK)
    worst = max(use, key=lambda name: use[name])
    return None if use[worst] <= 1.0 else f"its limit '{worst}' leaves too little motion"


def _spread(envelope: Envelope, values: Array, trajectory: Trajectory) -> float:
    """How wide the inertias' intervals will be, for equal noise on all torques."""
    motion = [each[::4] for each in trajectory.sampled(np.asarray(trajectory.middle), _TICK)]
    columns = torques(envelope.bar, *motion)[:, :, : len(INERTIAS)].reshape(-1, len(INERTIAS))
    alike = np.stack(
        [columns[:, 0] + columns[:, 1], columns[:, 2], columns[:, 3] + columns[:, 4]], axis=1
    )
    inverse = np.linalg.pinv(alike)
    return float(np.sum(np.sum(inverse**2, axis=1) / values[[0, 2, 3]] ** 2))
