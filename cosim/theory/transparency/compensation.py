"""The damping compensation b_c that nulls the DC damping at the actual delay, per object copy.

b_c is a force −b_c v sampled at T_c from each copy's own velocity and held; it is negative where it
compensates, and goes as it is into the ``compensation`` parameter of an object in a scenario.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cosim.base.errors import InputError
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import find_root
from cosim.theory.stability.spectral_radius import Stability, stability
from cosim.theory.transparency.damping import DampingModel, limit_damping, uniform_compensation

NEGLIGIBLE_DAMPING = 1e-9
"""N·s/m below which there is nothing to compensate."""


@dataclass(frozen=True, slots=True)
class Compensation:
    """What a user feels, and what cancels it.

    Attributes:
        damping: DC damping with b_c as the model has it, N·s/m.
        value: b_c per object copy that brings the DC damping to zero, N·s/m.
        compensated: stability of the loop with that b_c; marginal, because momentum is conserved.
    """

    damping: float
    value: float
    compensated: Stability


def null_compensation(
    model: Model, timing: Timing, user: int, kind: DampingModel = "original"
) -> Compensation:
    """Find b_c, the same on every copy, at which the DC damping vanishes.

    Args:
        model: a loop in free motion; its own b_c does not matter for the answer.
        timing: rates and delays.
        user: who feels it, counted from 0.
        kind: original or simplified model.

    Raises:
        InputError: where no compensation up to 1000 N·s/m reaches zero, or the loop is grounded.
    """
    present_damping = limit_damping(model, timing, user, kind)

    def damping(value: float) -> float:
        return limit_damping(uniform_compensation(model, value), timing, user, kind)

    value = nulling(damping)
    compensated = stability(uniform_compensation(model, value), timing)
    return Compensation(present_damping, value, compensated)


def nulling(damping: Callable[[float], float]) -> float:
    """The b_c (N·s/m) at which a damping, given as a function of it, vanishes; 0 where it does so.

    Raises:
        InputError: none up to 1000 N·s/m is enough.
    """
    uncompensated = damping(0.0)
    if abs(uncompensated) <= NEGLIGIBLE_DAMPING:
        return 0.0
    sign, reach = (-1.0 if uncompensated > 0 else 1.0), abs(uncompensated)
    while damping(sign * reach) * uncompensated > 0:
        reach *= 2.0
        if reach > 1000.0:
            raise InputError(
                f"No compensation up to 1000 N·s/m nulls the damping of {uncompensated:g} "
                "N·s/m: lower the stiffness, the delay or the ratio of the rates."
            )
    return find_root(damping, sign * reach, 0.0)
