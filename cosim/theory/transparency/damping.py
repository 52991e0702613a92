"""DC limit damping (6.2): the viscous friction that sampling and delay make the user feel."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Literal

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.assembly import assemble
from cosim.theory.models.direct import direct_model
from cosim.theory.models.mass_spring_damper import Centralized, Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Real
from cosim.theory.transparency.steady import steady_drift

DampingModel = Literal["original", "simplified"]
"""``original``: the force acts on the user's hand (Fig. 6.1). ``simplified``: there are no hands,
and the force acts directly on the object, on every copy of it (Fig. 6.3)."""


def limit_damping(
    model: Model, timing: Timing, user: int, kind: DampingModel = "original"
) -> float:
    """The DC damping b = lim F/V as z → 1 (6.2), force held over T_t, velocity at its start.

    Args:
        model: a loop in free motion.
        timing: rates and delays; any ratio.
        user: who pushes and feels, counted from 0; ignored by the simplified model.
        kind: where the force acts.

    Returns:
        N·s/m.

    Raises:
        InputError: where a wall holds the object, or the user has no hand in the model.
    """
    if model.grounded:
        raise InputError(
            "The damping is a property of free motion: set k_w = 0, or ask for the stiffness."
        )
    if kind == "simplified":
        model = replace(model, present=(False,) * model.users)
    elif not model.present[user]:
        raise InputError(f"User {user + 1} has no hand in this model, so feels nothing.")
    force, drift, place = _drift(model, timing, user, kind)
    return force / float(drift[place + 1])


def _drift(model: Model, timing: Timing, user: int, kind: DampingModel) -> tuple[float, Real, int]:
    """The force for a drift at 1 m/s, the state, and where the felt body is in it."""
    if not timing.has_frame:
        pushed = () if kind == "simplified" else (user,)
        direct = direct_model(model, timing, push_hands=pushed, push_objects=kind == "simplified")
        period = float(timing.network_period * direct.network_samples)
        force, drift = steady_drift(
            direct.lifted.map, direct.lifted.force, direct.translation, period
        )
        place = direct.body[0] if kind == "simplified" else direct.hand[user]
    else:
        frame = assemble(model, timing).frame()
        station = _station_of(model, user)
        effect = (
            frame.force_on_object.sum(axis=0)
            if kind == "simplified"
            else frame.force_on_hand[station]
        )
        force, drift = steady_drift(
            frame.map,
            frame.force_over_frame(effect),
            frame.translation,
            frame.samples * frame.control_period,
        )
        place = frame.body[0] if kind == "simplified" else frame.hand[station]
    assert place is not None
    return force, drift, place


def _station_of(model: Model, user: int) -> int:
    """The row of a user's hand in a frame: absent centralized clients have no station."""
    if isinstance(model, Centralized) and user > 0:
        return 1 + sum(model.present[1:user])
    return user


def distributed_damping_two_samples(
    object_mass: float, stiffness: float, damping: float, control_period: float
) -> float:
    """(6.3): the simplified distributed model at N = 2 and n = 0.

    Args:
        object_mass: m_o of each copy, kg.
        stiffness: k_o, N/m.
        damping: b_o, N·s/m.
        control_period: T_c, s.

    Returns:
        N·s/m.
    """
    denominator = 4 * object_mass / control_period - control_period * stiffness - 2 * damping
    return 2 * object_mass * stiffness / denominator


def centralized_damping_two_samples(
    object_mass: float, stiffness: float, damping: float, control_period: float
) -> float:
    """(B.10): the remote user of the centralized loop at N = 2 and any delay.

    Args:
        object_mass: m_o, kg.
        stiffness: k_2, N/m.
        damping: b_2, N·s/m.
        control_period: T_c, s.

    Returns:
        N·s/m.
    """
    return stiffness / (2 / control_period - damping / object_mass)


def original_damping_two_samples(
    *,
    T_c: float | Fraction,
    m_1: float | Fraction,
    m_o: float | Fraction,
    k_11: float | Fraction,
    b_11: float | Fraction,
    k_12: float | Fraction,
    b_12: float | Fraction,
    k_o: float | Fraction,
    b_o: float | Fraction,
) -> float | Fraction:
    """(B.11)–(B.13): the original distributed model at N = 2, exact for n = 1 (printed as n = 0).

    (B.12)'s M_o and T_o are read as m_o and T_c. Exact in whatever arithmetic it is given.

    Returns:
        N·s/m.
    """
    T, m1, mo = T_c, m_1, m_o
    numerator = (
        T
        * k_11
        * (
            10 * m1 * k_o**2 * T**2 * b_o * b_11
            - 24 * T * k_o**2 * m1 * mo * b_11
            - 40 * m1 * T * mo * k_o**2 * b_o
            - 24 * m1 * T * mo * k_o**2 * b_12
            + T**3 * b_12**2 * k_o**2 * b_11
            - 24 * T * b_11 * mo**2 * k_o**2
            - 4 * T**3 * b_11 * b_o**2 * k_o**2
            + 10 * m1 * T**2 * b_o * k_o**2 * b_12
            + 8 * m1 * T**2 * b_o**2 * k_o**2
            - 4 * T**3 * b_11 * b_o * k_o**2 * b_12
            + 10 * T**2 * b_11 * mo * k_o**2 * b_12
            + 12 * m1 * T**2 * k_o**2 * b_12 * b_11
            + 48 * m1 * mo**2 * k_o**2
            + 20 * T**2 * b_11 * mo * k_o**2 * b_o
            - 2 * T**2 * k_12**2 * mo * b_o * b_11
            - 2 * T**2 * k_12**2 * m1 * b_o**2
            - 2 * T**2 * k_12**2 * m1 * b_o * b_11
            + 4 * T * k_12**2 * m1 * mo * b_o
            + T**3 * k_12**2 * b_o**2 * b_11
            + 8 * T**2 * m1 * b_11 * k_o * b_o * k_12
            - 40 * T * m1 * mo * k_o * b_o * k_12
            - 4 * T**3 * k_o * b_o**2 * b_11 * k_12
            + 8 * T**2 * m1 * b_o**2 * k_o * k_12
            + 12 * m1 * T**2 * b_11 * k_o * b_12 * k_12
            + 12 * m1 * T**2 * b_o * k_o * b_12 * k_12
            + 20 * T**2 * mo * k_o * b_o * k_12 * b_11
            + 12 * T**2 * mo * k_12 * k_o * b_12 * b_11
            - 6 * T**3 * k_12 * k_o * b_12 * b_11 * b_o
            - 24 * m1 * mo * T * k_o * b_12 * k_12
            + 48 * m1 * mo**2 * k_12 * k_o
            - 24 * T * mo**2 * k_12 * k_o * b_11
            - 24 * m1 * mo * T * b_11 * k_o * k_12
        )
    )
    denominator = (
        (T * b_o + T * b_12 - 2 * mo)
        * (k_11 * k_12 + k_o * k_12 + k_11 * k_o)
        * (
            -(T**3) * b_11 * k_o
            - 2 * T**2 * b_11 * b_o
            + 4 * m1 * T * b_o
            + 4 * m1 * T * b_11
            + 4 * mo * T * b_11
            - 8 * m1 * mo
        )
    )
    return numerator / denominator


def uniform_compensation(model: Model, value: float) -> Model:
    """The model with b_c of ``value`` (N·s/m) on every object copy."""
    if isinstance(model, Centralized):
        return replace(model, compensation=value)
    return replace(model, compensation=np.full(model.users, value))
