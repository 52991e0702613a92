"""Where the grasp breaks: predicted by the theory, found by simulation.

Limits of the grasp and carry of figure 8.1: the stiffest couplers of the remote user that hold
under the centralized controller, over the round-trip delay and over the jitter of a network without
other delay; and the packet loss up to which either controller holds, over the round-trip delay,
with the couplers of section 8.2 for whoever is across the network.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Literal

import numpy as np

from cosim.thesis.experiments import bundled_file
from cosim.thesis.sweeps.trials import grasp

if TYPE_CHECKING:
    from cosim.theory.models.mass_spring_damper import Model

Curve = Literal["stiffness", "jitter", "centralized_loss", "distributed_loss"]

CURVES: tuple[Curve, ...] = ("stiffness", "jitter", "centralized_loss", "distributed_loss")
DELAYS: dict[Curve, tuple[int, ...]] = {
    "stiffness": (0, 1, 2, 3, 4),
    "jitter": (0, 1, 2, 3),
    "centralized_loss": (0, 1, 2, 3),
    "distributed_loss": (0, 2, 4),
}
"""Round trips in network samples; for ``jitter`` the span over which each packet is late."""

STIFFNESSES = (25.0, 2000.0)
"""The search begins with these remote normal stiffnesses (N/m)."""

STEPS: dict[Curve, int] = {
    "stiffness": 5,
    "jitter": 5,
    "centralized_loss": 4,
    "distributed_loss": 4,
}
"""Bisections: each one halves the interval that a limit is known to be in."""

NEUTRAL = 1e-4
"""A second moment that grows by less than this a frame is that of a neutral mode, as well as the
eigenvalue iteration resolves it."""

DURATION = 4.5
"""Of a trial (s): up to the end of the way there."""

CENTRALIZED = "thesis/grasp_centralized_soft"
DISTRIBUTED = "thesis/grasp_distributed"
_RECORD = {
    CENTRALIZED: "server.finger_?.force, client.finger_?.force, server.finger_?.contact_state, "
    "server.client_contact_1.finger_?_contact_state",
    DISTRIBUTED: "vr_?.finger_?.force, vr_?.finger_?.contact_state, "
    "vr_?.peer_contact_1.finger_?_contact_state",
}


@dataclass(frozen=True, slots=True)
class Limit:
    """One point of a curve (N/m, or a probability).

    ``predicted`` is where the theory has the first mode unstable, ``None`` where it has none;
    ``holds`` is the largest value that held in simulation, ``breaks`` the smallest that did not.
    """

    curve: Curve
    delay: int
    predicted: float | None
    holds: float
    breaks: float

    @property
    def found(self) -> float:
        """The middle of the interval in which simulation has the limit."""
        if self.curve in {"stiffness", "jitter"}:
            return float(np.sqrt(self.holds * self.breaks))
        return (self.holds + self.breaks) / 2


def find_limit(curve: Curve, delay: int) -> Limit:
    """Predict one point of a curve, and find it by simulation."""
    if curve in {"stiffness", "jitter"}:
        low, high = STIFFNESSES
        trip, jitter = (0, delay) if curve == "jitter" else (delay, 0)
        found = _bisect(
            lambda x: holds(CENTRALIZED, trip, stiffness=float(np.exp(x)), jitter=jitter),
            float(np.log(low)),
            float(np.log(high)),
            STEPS[curve],
        )
        found = float(np.exp(found[0])), float(np.exp(found[1]))
    else:
        file = CENTRALIZED if curve == "centralized_loss" else DISTRIBUTED
        found = (0.0, 0.0)
        if holds(file, delay):
            found = _bisect(lambda x: holds(file, delay, loss=x), 0.0, 1.0, STEPS[curve])
    return Limit(curve, delay, predict(curve, delay), *found)


def predict(curve: Curve, delay: int) -> float | None:
    """Where the first mode of the grasp becomes unstable, in the mean square under loss."""
    from cosim.analysis.grasp import find_grasp
    from cosim.analysis.modes import centralized_modes, distributed_modes
    from cosim.scenario import load
    from cosim.theory.chance.mean_square import critical_loss, mean_square_radius
    from cosim.theory.chance.packets import random_delay
    from cosim.theory.models.timing import PathDelay, Timing
    from cosim.theory.stability.spectral_radius import stability

    timing = Timing(delay=PathDelay.round_trip(0 if curve == "jitter" else delay))
    if curve in {"stiffness", "jitter"}:
        server = load(bundled_file(CENTRALIZED)).components["server"]

        def stable(x: float) -> bool:
            found = centralized_modes(server, remote_stiffness=float(np.exp(x))).values()
            if curve == "jitter" and delay > 0:
                late = [1.0] * (delay + 1)
                radii = (mean_square_radius(m, timing, lambda _: random_delay(late)) for m in found)
                return all(radius <= 1.0 + NEUTRAL for radius in radii)
            return all(stability(model, timing).stable for model in found)

        # From soft to stiff each mode becomes unstable once within this range.
        low, high = np.log(STIFFNESSES)
        return float(np.exp(_bisect(stable, low, high, 20)[0]))
    models: list[Model] = []
    if curve == "centralized_loss":
        models += centralized_modes(load(bundled_file(CENTRALIZED)).components["server"]).values()
    else:
        scenario = load(bundled_file(DISTRIBUTED), (), [f"channels.lan.round_trip_delay={delay}"])
        timing = replace(timing, delay=find_grasp(scenario).timing.delay)
        models += distributed_modes(scenario).values()
    losses = [critical_loss(model, timing) for model in models]
    return min((loss for loss in losses if loss is not None), default=None)


def holds(
    file: str,
    delay: int,
    *,
    stiffness: float | None = None,
    loss: float = 0.0,
    jitter: int = 0,
) -> bool:
    """Whether a grasp holds at a round trip of ``delay`` samples.

    Args:
        file: ``CENTRALIZED`` or ``DISTRIBUTED``.
        delay: in network samples.
        stiffness: remote normal stiffness (N/m), the tangential one in proportion; as the scenario
            has it unless given.
        loss: probability of losing a packet.
        jitter: each packet is late by 0 to this many network samples, all equally likely.
    """
    sets = [
        "expect=~",
        f"record=[{_RECORD[file]}]",
        f"duration={DURATION}",
        f"channels.lan.round_trip_delay={delay}",
        f"channels.lan.loss={loss}",
        f"channels.lan.jitter={jitter}",
    ]
    if stiffness is not None:
        parameters = "components.server.parameters.remote"
        normal, tangential = soft_stiffness()
        sets += [
            f"{parameters}_normal_stiffness={stiffness}",
            f"{parameters}_tangential_stiffness={stiffness * tangential / normal}",
        ]
    return grasp(file, sets).holds


@cache
def soft_stiffness() -> tuple[float, float]:
    """The remote user's stiffness in section 8.2, along the normal and along the face (N/m)."""
    from cosim.analysis.parameter import parameter
    from cosim.scenario import load

    server = load(bundled_file(CENTRALIZED)).components["server"]
    return parameter(server, "remote_normal_stiffness"), parameter(
        server, "remote_tangential_stiffness"
    )


def _bisect(
    holds: Callable[[float], bool], low: float, high: float, steps: int
) -> tuple[float, float]:
    for _ in range(steps):
        middle = (low + high) / 2
        if holds(middle):
            low = middle
        else:
            high = middle
    return low, high
