"""Stiffness that a user feels in rigid contact, at equilibrium (6.4)–(6.5)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.base.errors import InputError
from cosim.theory.models.mass_spring_damper import Centralized, Model
from cosim.theory.numerics import Real, solve


def equivalent_stiffness(model: Model, user: int) -> float:
    """k_eq = F/X of a user's hand at equilibrium, by the static balance of every body.

    Args:
        model: a loop whose objects press on a wall.
        user: who pushes, counted from 0; must have a hand in the model.

    Returns:
        N/m.

    Raises:
        InputError: where nothing holds the object.
    """
    if not model.grounded:
        raise InputError("Without a wall nothing is stiff at equilibrium: set k_w above 0.")
    balance, hands = _static_balance(model)
    hand = hands[user]
    if hand is None:
        raise InputError(f"User {user + 1} has no hand in this model, so feels nothing.")
    push = np.zeros(balance.shape[0])
    push[hand] = 1.0
    try:
        moved = solve(balance, push)
    except np.linalg.LinAlgError:
        raise InputError(
            "A hand is tied to nothing (its coupler's stiffness is 0), so there is no equilibrium."
        ) from None
    return float(1.0 / moved[hand])


def _static_balance(model: Model) -> tuple[Real, list[int | None]]:
    """The matrix G of G x = f over hands and object copies, and where the hands are."""
    objects = 1 if isinstance(model, Centralized) else model.users
    hands: list[int | None] = []
    size = objects
    for present in model.present:
        hands.append(size if present else None)
        size += 1 if present else 0
    G = np.zeros((size, size))

    def tie(body: int, other: int, stiffness: float) -> None:
        G[body, body] += stiffness
        G[body, other] -= stiffness

    for m, hand in enumerate(hands):
        if hand is None:
            continue
        if isinstance(model, Centralized):
            tie(hand, 0, float(model.stiffness[m]))
            tie(0, hand, float(model.stiffness[m]))
            continue
        tie(hand, m, float(model.local_stiffness[m]))
        tie(m, hand, float(model.local_stiffness[m]))
        for r in range(model.users):
            if r != m:
                tie(r, hand, float(model.remote_stiffness[r, m]))
    if not isinstance(model, Centralized):
        for m in range(model.users):
            for r in range(model.users):
                if r != m:
                    tie(m, r, float(model.object_stiffness[m, r]))
    for copy in range(objects):
        G[copy, copy] += model.wall_stiffness
    return G, hands


@dataclass(frozen=True, slots=True)
class DistributedStiffness:
    """(6.4) for the distributed loop of Fig. 6.1(c), in N/m.

    Attributes:
        corrected: with the 2 k_o² terms left out, which is what the balance of forces gives.
        as_printed: with them, as the thesis prints it.
        rigid_limit: k_11, the limit for a rigid wall (6.5).
    """

    corrected: float
    as_printed: float
    rigid_limit: float


def distributed_stiffness(k_11: float, k_21: float, k_o: float, k_w: float) -> DistributedStiffness:
    """The closed form (6.4) of the distributed loop, corrected and as printed (all N/m)."""

    def closed_form(slip: float) -> float:
        copies = slip * k_o**2 + k_21 * k_w + 2 * k_o * k_w + k_w**2
        return k_11 * copies / (k_o * k_21 + k_21 * k_11 + k_11 * k_o + k_11 * k_w + copies)

    return DistributedStiffness(closed_form(0.0), closed_form(2.0), k_11)


def series_stiffness(coupler: float, wall: float) -> float:
    """A coupler against a wall, k_2 k_w / (k_2 + k_w), as in (6.4) for the remote user (N/m)."""
    return coupler * wall / (coupler + wall)
