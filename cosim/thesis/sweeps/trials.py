"""Short runs in memory: a grasp that holds or does not, a motion and the force that it takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cosim.base.recording import MemorySink
from cosim.thesis.experiments import bundled_file

SETTLED = 2.0
"""All fingers have touched the box and squeeze it from here on (s)."""

STEADY = 0.5
"""A force that ripples by more than this (N, rms) is not a steady grasp."""

SWUNG_IN = 4.575
"""The free motion is periodic from here on (s)."""

FREQUENCY = 2.0
"""Of the free motion's sine (rad/s)."""


@dataclass(frozen=True, slots=True)
class Steadiness:
    """How a grasp went from ``SETTLED`` to the end of the run.

    ``losses`` is how often a contact ended, over all fingers and copies; ``ripple`` the rms
    deviation from its mean (N) of the worst component of a force that a user feels.
    """

    losses: int
    ripple: float

    @property
    def holds(self) -> bool:
        """No contact was lost, and no force rippled by more than ``STEADY``."""
        return self.losses == 0 and self.ripple <= STEADY


@dataclass(frozen=True, slots=True)
class Motion:
    """The free motion once it is periodic: both users' forces added up, and the two copies.

    ``net_force`` is the amplitude (N) of the sine that fits the sum, ``ripple`` the rms (N) of what
    is left of it, ``drift`` the rms distance (m) between the copies of the box.
    """

    net_force: float
    ripple: float
    drift: float


def grasp(file: str, sets: Sequence[str]) -> Steadiness:
    """Run a grasp with overrides and say how steady it was; every recorded real is a force.

    Raises:
        InputError: the scenario cannot be used.
        RunError: it failed on the way.
    """
    sink = _run(file, sets)
    losses, ripple = 0, 0.0
    for number, group in enumerate(sink.groups):
        rows = sink.rows(number)[int(SETTLED * sink.base_rate / group.period) :]
        for index, column in enumerate(group.columns):
            cells = np.ascontiguousarray(rows[:, index])
            if column.name.endswith("contact_state"):
                ended = (cells[:-1] != 0) & (cells[1:] == 0)
                losses += int(np.count_nonzero(ended)) + int(cells[0] == 0)
            elif column.is_float:
                ripple = max(ripple, float(np.std(cells.view(np.float64))))
    return Steadiness(losses, ripple)


def free_motion(sets: Sequence[str]) -> Motion:
    """Run the free motion of figure 8.3 with overrides.

    Raises:
        InputError: the scenario cannot be used.
        RunError: it failed on the way.
    """
    record = "record=[vr_?.finger_1.normal_force, vr_?.box_pose.y]"
    sink = _run("thesis/free_motion", ["expect=~", record, *sets])

    def signal(name: str) -> NDArray[np.float64]:
        return np.asarray(sink.signal(name), np.float64)

    first = int(SWUNG_IN * sink.base_rate)
    net = signal("vr_a.finger_1.normal_force") - signal("vr_b.finger_1.normal_force")
    apart = signal("vr_a.box_pose.y") - signal("vr_b.box_pose.y")
    angle = FREQUENCY * np.arange(first, net.size) / float(sink.base_rate)
    basis = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    fit = np.linalg.lstsq(basis, net[first:], rcond=None)[0]
    return Motion(
        net_force=float(np.hypot(fit[1], fit[2])),
        ripple=float(np.std(net[first:] - basis @ fit)),
        drift=float(np.sqrt(np.mean(apart[first:] ** 2))),
    )


def _run(file: str, sets: Sequence[str]) -> MemorySink:
    from cosim.analysis import load_tuned
    from cosim.master.run.simulation import assemble

    sink = MemorySink()
    with assemble(load_tuned(bundled_file(file), (), sets)) as simulation:
        simulation.run(sink)
    return sink
