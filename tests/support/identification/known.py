"""Recordings made backwards: a motion is given, the torque is what it needs.

Only the arithmetic of estimation is tried with these, because the regressor itself makes them; what
identifies devices is tried on emulators, which are built of other equations.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from cosim.identification.excitation.trajectory import Trajectory
from cosim.identification.five_bar import FiveBar
from cosim.identification.nominal import Nominal
from cosim.identification.regressor import MASS, at_tip, torques
from cosim.identification.samples import Described, Recording

TICK = 1 / 1024
HAPLY = FiveBar(proximal=0.070, distal=0.090, base=0.038)
HOME = (2.4273310762646136, 0.7142615773251793)
VALUES = Nominal.of("haply").values(HAPLY)
DEVICE = Described(bar=HAPLY, preset="haply", limit=0.12, latency_ticks=1, home=HOME)
FINE = 8
"""Parts of a tick that delays are whole numbers of."""


@cache
def motion(seed: int, seconds: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Angles, rates and accelerations, a row an eighth of a tick."""
    path = Trajectory(middle=HOME, slow=0.35, fast=300.0, seconds=seconds, seed=seed)
    return path.sampled(np.asarray(HOME), TICK / FINE)


def known(
    *,
    seed: int = 1,
    seconds: float = 12.0,
    payload: float = 0.0,
    delay: float = 1.0,
    offset: tuple[float, float] = (0.0, 0.0),
    gain: tuple[float, float] = (1.0, 1.0),
    counts: int = 48800,
    force: tuple[float, float] | None = None,
    heavier: float = 0.0,
) -> Recording:
    """A run with a payload (kg), a delay (ticks), offsets (rad), gains and a force (N).

    The second side has ``heavier`` (kg.m2) more inertia than the first.
    """
    angle, rate, acceleration = motion(seed, seconds)
    values = VALUES.copy()
    values[MASS] += payload
    values[1] += heavier
    rows = len(angle) // FINE - 12
    # What is held from a tick on is the mean that the motion needs meanwhile.
    acting = np.arange(rows) * FINE + round(delay * FINE) + FINE // 2
    needed = torques(HAPLY, angle[acting], rate[acting], acceleration[acting]) @ values
    pushed = None
    if force is not None:
        wave = np.sin(2 * np.pi * np.outer(np.arange(rows) * TICK, (0.7, 1.1)))
        pushed = wave * force
        moved = HAPLY.motion(angle[acting], rate[acting], acceleration[acting])
        needed -= at_tip(moved, pushed)
    quantum = 2 * np.pi / counts
    shown = np.round((angle[: rows * FINE : FINE] + offset) / quantum) * quantum
    ticks = np.arange(rows)
    return Recording(
        name=f"known-{seed}",
        digest="0" * 64,
        date="2026-11-27",
        tick=TICK,
        ticks=ticks,
        angle=shown,
        torque=needed / gain,
        age=np.zeros(rows, dtype=np.int64),
        status=np.full(rows, 11),
        limit=0.12,
        payload=payload,
        force=pushed,
    )


def changed(recording: Recording, **values: object) -> Recording:
    """The same run but for some of its columns."""
    return replace(recording, **values)
