"""The single-axis modes of a grasp with two fingers a user, as the models of figures 4.3 and 4.4.

While the contacts stick, the grasp of two fingers on opposite faces falls apart into modes that do
not feel each other, each one hand a user on one object:

- *squeeze*: a user's fingers against each other. The box does not move: its mass is out of reach.
- *carry*: both fingers and the box along the normals; two fingers are one of twice everything.
- *lift*: the same along the faces, on the tangential couplers.
- *turn*: the fingers along the faces, one up and one down; the box is its inertia over the square
  of half its side.

The hands' own stiffness and damping are in the models; the devices' friction, encoders and velocity
estimation are not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from cosim.analysis.grasp import Axis, find_grasp
from cosim.analysis.parameter import parameter
from cosim.scenario import Scenario, ScenarioComponent
from cosim.theory.models.mass_spring_damper import Centralized, Distributed

RELAXED = (100.0, 3.0)
"""Stiffness (N/m) and damping (N·s/m) of the operator's relaxed hand."""

IMMOVABLE = 1e6
"""Mass of an object that nobody moves (kg)."""


@dataclass(frozen=True, slots=True)
class Mode:
    """Along which coupler, with how many fingers a user, against which mass (kg)."""

    axis: Axis
    fingers: int
    mass: float


def modes(part: ScenarioComponent) -> Mapping[str, Mode]:
    """The modes of a grasp of the box that a workstation simulates."""
    mass, side = parameter(part, "mass"), parameter(part, "side")
    turning = parameter(part, "inertia") / (side / 2) ** 2
    return {
        "squeeze": Mode("normal", 1, IMMOVABLE),
        "carry": Mode("normal", 2, mass),
        "lift": Mode("tangential", 2, mass),
        "turn": Mode("tangential", 2, turning),
    }


def centralized_modes(
    server: ScenarioComponent, *, remote_stiffness: float | None = None
) -> Mapping[str, Centralized]:
    """Each mode of the grasp of a ``central_server`` with one client, hands relaxed.

    Args:
        server: the component.
        remote_stiffness: takes the place of the remote normal stiffness (N/m); the tangential one
            changes in proportion.
    """
    factor = 1.0
    if remote_stiffness is not None:
        factor = remote_stiffness / parameter(server, "remote_normal_stiffness")
    found: dict[str, Centralized] = {}
    for name, mode in modes(server).items():
        stiffness, damping = (
            mode.fingers
            * np.array(
                [parameter(server, f"{who}_{mode.axis}_{what}") for who in ("local", "remote")]
            )
            for what in ("stiffness", "damping")
        )
        found[name] = Centralized(
            present=(True, True),
            hand_mass=mode.fingers * np.full(2, parameter(server, "hand_mass")),
            hand_damping=mode.fingers * np.full(2, RELAXED[1]),
            object_mass=mode.mass,
            stiffness=stiffness * np.array([1.0, factor]),
            damping=damping,
            hand_stiffness=mode.fingers * RELAXED[0],
        )
    return found


def distributed_modes(scenario: Scenario, fingers: int = 2) -> Mapping[str, Distributed]:
    """The carry and lift modes of the grasp of a distributed scenario, hands relaxed.

    ``fingers`` is how many fingers each user has on the axis.
    """
    grasp = find_grasp(scenario)
    found: dict[str, Distributed] = {}
    axes: tuple[tuple[str, Axis], ...] = (("carry", "normal"), ("lift", "tangential"))
    for name, axis in axes:
        model = grasp.model(axis)
        found[name] = replace(
            model,
            hand_mass=fingers * model.hand_mass,
            hand_damping=fingers * np.full(model.users, RELAXED[1]),
            hand_stiffness=fingers * RELAXED[0],
            local_stiffness=fingers * model.local_stiffness,
            local_damping=fingers * model.local_damping,
            remote_stiffness=fingers * model.remote_stiffness,
            remote_damping=fingers * model.remote_damping,
        )
    return found
