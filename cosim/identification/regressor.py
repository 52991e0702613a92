"""The five-bar's joint torques as a linear function of what it is made of.

A rigid link that joins E to P has the kinetic energy a|E'|^2/2 + c|P'|^2/2 + b E'.P' whatever its
mass and where its centre lies on the line, so the energy of the mechanism is

    T = J_1 q_1'^2/2 + J_2 q_2'^2/2 + M|P'|^2/2 + phi_1 E_1'.P' + phi_2 E_2'.P'

with, for uniform links of mass m and inertia I, nu = m/4 + I/L^2 and phi = m/4 - I/L^2:
J = I_proximal + rotor + nu l^2, M = tip mass + 2 nu. Lagrange's equations of the five terms are
the columns. Friction is Coulomb's and viscous, each joint its own; the motor's bias is a constant.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cosim.identification.five_bar import Array, FiveBar, MovedBar


@dataclass(frozen=True, slots=True)
class Coefficient:
    """One unknown: its name, unit, and what it is."""

    name: str
    unit: str
    description: str


INERTIAS = (
    Coefficient("J_1", "kg.m2", "inertia of joint 1's proximal side, with its part of the distal"),
    Coefficient("J_2", "kg.m2", "inertia of joint 2's proximal side, with its part of the distal"),
    Coefficient("M", "kg", "mass that moves with the tip, with its part of the distal links"),
    Coefficient("phi_1", "kg", "coupling of elbow 1 and tip"),
    Coefficient("phi_2", "kg", "coupling of elbow 2 and tip"),
)
FRICTIONS = (
    Coefficient("coulomb_1", "N.m", "Coulomb friction of joint 1"),
    Coefficient("coulomb_2", "N.m", "Coulomb friction of joint 2"),
    Coefficient("viscous_1", "N.m.s/rad", "viscous friction of joint 1"),
    Coefficient("viscous_2", "N.m.s/rad", "viscous friction of joint 2"),
    Coefficient("bias_1", "N.m", "constant torque of joint 1"),
    Coefficient("bias_2", "N.m", "constant torque of joint 2"),
)
PARAMETERS = (*INERTIAS, *FRICTIONS)
"""The columns of ``torques`` in their order."""
MASS = 2
"""The column of what is carried at the tip."""


def torques(bar: FiveBar, angle: Array, rate: Array, acceleration: Array) -> Array:
    """Joint torques (N.m) for each parameter at one, shape (samples, 2, parameters)."""
    motion = bar.motion(angle, rate, acceleration)
    columns = np.zeros((len(angle), 2, len(PARAMETERS)))
    columns[:, :, : len(INERTIAS)] = inertial(motion, acceleration)
    slides = np.sign(rate)
    for joint in (0, 1):
        for at, value in enumerate((slides[:, joint], rate[:, joint], 1.0)):
            columns[:, joint, len(INERTIAS) + 2 * at + joint] = value
    return columns


def inertial(motion: MovedBar, acceleration: Array) -> Array:
    """The inertial columns, shape (samples, 2, 5)."""
    columns = np.zeros((len(acceleration), 2, len(INERTIAS)))
    columns[:, 0, 0], columns[:, 1, 1] = acceleration[:, 0], acceleration[:, 1]
    columns[:, :, MASS] = at_tip(motion, motion.tip_acceleration)
    for joint in (0, 1):
        # d/dt of dT/dq' less dT/dq of E'.P': each end is accelerated by the other's force.
        columns[:, :, 3 + joint] = at_tip(motion, motion.elbow_acceleration[joint])
        columns[:, joint, 3 + joint] += np.einsum(
            "si,si->s", motion.elbow_jacobian[joint], motion.tip_acceleration
        )
    return columns


def at_tip(motion: MovedBar, force: Array) -> Array:
    """The joint torques (samples, 2) that hold a force (samples, 2) at the tip: J^T F."""
    return np.einsum("sij,si->sj", motion.jacobian, force)


def inertia_matrix(bar: FiveBar, angle: Sequence[float]) -> Array:
    """The joint-space inertia at one pose for each inertial parameter at one, shape (2, 2, 5)."""
    pose, still = np.tile(np.asarray(angle, dtype=np.float64), (2, 1)), np.zeros((2, 2))
    turned = np.eye(2)
    columns = inertial(bar.motion(pose, still, turned), turned)
    return np.swapaxes(columns, 0, 1)
