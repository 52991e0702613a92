"""Rows of records as equations of motion: smoothed torque on the left, known columns on the right.

Delay, encoder offsets and torque gains enter nonlinearly: ``Rows`` is made for one value of each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.base.errors import InputError
from cosim.identification.five_bar import Array, FiveBar
from cosim.identification.kernels import Kernel
from cosim.identification.regressor import INERTIAS, MASS, PARAMETERS, at_tip, inertial
from cosim.identification.samples import Recording

WIDTH = 12e-3
"""Standard deviation of the kernel (s): flat to 0.2 % at 8 Hz, to 3 % at 15 Hz; shorter ones let
counts bias offsets (8 ms: by 2 mrad with 4880 counts a turn), longer ones bend more."""
SLOWEST = 0.4
"""rad/s: a joint slower than this may stick, and then its friction is anything below Coulomb's."""
LEAST_SECONDS = 10.0
"""Of rows that count, all runs together."""


@dataclass(slots=True, kw_only=True)
class Stretch:
    """Smoothed rows of one run without a gap: what no unknown changes."""

    recording: Recording
    kernel: Kernel
    angle: Array
    rate: Array
    acceleration: Array
    friction: Array
    """Columns of friction and bias, (rows, 2, 6)."""
    bend: Array
    """What the smoothed inertial columns are more than those of smoothed motion, (rows, 2, 5)."""
    chosen: NDArray[np.intp]
    """Rows of the smoothed arrays that make an equation."""
    held: Array
    """Torque from twice the kernel's reach before the first row, as recorded."""
    force: Array | None
    block: NDArray[np.int64]
    """Which second of the record each chosen row is of."""
    payload: float = 0.0

    def torque(self, delay: float) -> Array:
        """Smoothed torque of the chosen rows (rows, 2) with a delay (s)."""
        reach = self.kernel.reach
        return self.kernel.smooth_held(self.held, delay)[reach:-reach][self.chosen]


def stretches(
    bar: FiveBar, recordings: list[Recording], steps: list[int], *, still: float = SLOWEST
) -> list[Stretch]:
    """All that can be used of the recordings.

    Raises:
        InputError: too little is left.
    """
    found: list[Stretch] = []
    seconds = 0.0
    for recording, step in zip(recordings, steps, strict=True):
        kernel = Kernel(width=WIDTH, tick=recording.tick)
        shortest = 6 * kernel.reach
        bridged = recording.bridged()
        for rows in bridged.stretches(shortest, step):
            made = _stretch(bar, bridged, kernel, rows, still)
            seconds += (rows.stop - rows.start) * recording.tick
            if len(made.chosen):
                found.append(made)
    if seconds < LEAST_SECONDS:
        raise InputError(
            f"{seconds:.1f} s of these runs can be used, {LEAST_SECONDS:.0f} s are needed: with "
            "the output on, new samples, and no joint at its torque limit. Run the excitation of "
            "'cohaptic identify --plan' for longer."
        )
    if not found:
        raise InputError(
            f"the joints hardly move in these runs (never faster than {still} rad/s both at once): "
            "nothing can be told from them. Run the excitation of 'cohaptic identify --plan'."
        )
    return found


def _stretch(
    bar: FiveBar, recording: Recording, kernel: Kernel, rows: slice, still: float
) -> Stretch:
    angle, reach = recording.angle[rows], kernel.reach
    places, rates, gains = (kernel.smooth(angle, order) for order in range(3))
    # Friction changes sides at once: its columns go through the kernel as the torque does.
    sides = kernel.smooth(np.sign(rates))
    bend = _bend(bar, kernel, places, rates, gains)
    places, gains = places[reach:-reach], gains[reach:-reach]
    friction = np.zeros((len(places), 2, len(PARAMETERS) - len(INERTIAS)))
    inner = rates[reach:-reach]
    for joint in (0, 1):
        for at, column in enumerate((sides[:, joint], inner[:, joint], 1.0)):
            friction[:, joint, 2 * at + joint] = column
    moves = np.all(np.abs(inner) >= still, axis=1)
    stride = max(1, round(kernel.width / kernel.tick))
    chosen = np.flatnonzero(moves)[::stride]
    force = None if recording.force is None else kernel.smooth(recording.force[rows])[reach:-reach]
    first = recording.ticks[rows][2 * reach : -2 * reach]
    return Stretch(
        recording=recording,
        kernel=kernel,
        angle=places[chosen],
        rate=inner[chosen],
        acceleration=gains[chosen],
        friction=friction[chosen],
        bend=bend[chosen],
        chosen=chosen,
        held=recording.torque[rows],
        force=None if force is None else force[chosen],
        block=(np.arange(len(first))[chosen] * kernel.tick).astype(np.int64),
        payload=recording.payload or 0.0,
    )


def _bend(bar: FiveBar, kernel: Kernel, angle: Array, rate: Array, gain: Array) -> Array:
    """Smoothing and then bending is not bending and then smoothing: by how much, to first order.

    The mechanism bends a motion that is smoothed once; the difference is seen by smoothing again.
    """
    first = inertial(bar.motion(angle, rate, gain), gain)
    wide = kernel.smooth(first.reshape(len(first), -1)).reshape(-1, *first.shape[1:])
    again = [kernel.smooth(each) for each in (angle, rate, gain)]
    return wide - inertial(bar.motion(again[0], again[1], again[2]), again[2])


def columns(bar: FiveBar, stretch: Stretch, offset: Array) -> tuple[Array, Array]:
    """Right-hand side (rows, 2, parameters) and what is known of it (rows, 2), in N.m.

    Known are the payload's inertia and the force on the tip; ``offset`` (rad) is what the encoders
    show too much.
    """
    motion = bar.motion(stretch.angle - offset, stretch.rate, stretch.acceleration)
    inertias = inertial(motion, stretch.acceleration) + stretch.bend
    known = stretch.payload * inertias[:, :, MASS]
    if stretch.force is not None:
        known = known - at_tip(motion, stretch.force)
    return np.concatenate([inertias, stretch.friction], axis=2), known
