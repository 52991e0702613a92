"""One workstation's loop at the control rate: hand, object, virtual couplers (3.18), (4.2), (4.9).

Everything here broadcasts: any stiffness, damping or mass may be an array, and the matrices then
carry its shape in front. That is what makes whole stability maps cheap.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cosim.theory.models.zero_order_hold import mass_under_held_force
from cosim.theory.numerics import Real

Value = Real | float


@dataclass(frozen=True, slots=True)
class Station:
    """A discrete-time subsystem x⁺ = A x + B u + E f, r = C x + D u at T_c.

    Attributes:
        A: shape (..., n, n).
        B: shape (..., n, J), one held input per held coupler, N.
        C: shape (..., J, n), what each held coupler applies to the object, N.
        D: shape (..., J, J), its feedthrough (zero under a computation delay).
        force_on_hand: shape (..., n), the effect of 1 N on the hand over one tick (zeros if none).
        force_on_object: shape (..., n), the effect of 1 N on the object over one tick.
        hand: index of the hand's position in the state, or None; its velocity is the next.
        body: index of the object's position in the state, or None; its velocity is the next.
        translation: shape (n,), the state after everything moved by 1 m, held inputs apart.
    """

    A: Real
    B: Real
    C: Real
    D: Real
    force_on_hand: Real
    force_on_object: Real
    hand: int | None
    body: int | None
    translation: Real


def hand_alone(mass: Value, damping: Value, stiffness: float = 0.0, *, period: float) -> Station:
    """A remote user's hand under the force that it receives (4.3); the force acts as −u."""
    A, b = mass_under_held_force(mass, damping, period, stiffness)
    shape = A.shape[:-2]
    return Station(
        A=A,
        B=-b[..., None],
        C=np.zeros((*shape, 1, 2)),
        D=np.zeros((*shape, 1, 1)),
        force_on_hand=b,
        force_on_object=np.zeros((*shape, 2)),
        hand=0,
        body=None,
        translation=np.array([1.0, 0.0]),
    )


def object_station(
    *,
    hand: tuple[Value, Value] | tuple[Value, Value, float] | None,
    local: tuple[Value, Value],
    object_mass: Value,
    compensation: Value,
    held: Sequence[tuple[Value, Value]],
    period: float,
    computation_delay: int,
) -> Station:
    """An object with an optional local hand and couplers to values that others send.

    A held coupler j applies u_j − (k_j x_o + b_j v_o) to the object, u_j being the other side's
    share K X̄, held by the network. The wall of Fig. 6.1 is one with u = 0.

    Args:
        hand: mass (kg), physical damping (N·s/m) and, where it has one, stiffness to the ground
            (N/m) of the local hand, or None.
        local: stiffness (N/m) and damping (N·s/m) between local hand and object.
        object_mass: kg.
        compensation: b_c in N·s/m: −b_c v_o, sampled at T_c and held, without computation delay.
        held: stiffness and damping of each held coupler.
        period: T_c in s.
        computation_delay: ticks between a coupler's inputs and its force.
    """
    shape = _common_shape(hand, local, object_mass, compensation, held)
    has_hand = hand is not None
    forces = (1 if has_hand else 0) + len(held)
    body = 2 if has_hand else 0
    chain = body + 2
    size = chain + forces * computation_delay
    A = np.zeros((*shape, size, size))
    B = np.zeros((*shape, size, len(held)))
    C = np.zeros((*shape, len(held), size))
    D = np.zeros((*shape, len(held), len(held)))

    object_A, object_b = mass_under_held_force(object_mass, 0.0, period)
    A[..., body : body + 2, body : body + 2] = object_A
    push_object = np.zeros((*shape, size))
    push_object[..., body : body + 2] = object_b
    push_hand = np.zeros((*shape, size))
    if hand is not None:
        hand_A, hand_b = mass_under_held_force(hand[0], hand[1], period, *hand[2:])
        A[..., :2, :2] = hand_A
        push_hand[..., :2] = hand_b

    # Each force as a row over the state, and what it pushes.
    rows: list[tuple[Real, Real, int | None]] = []
    if has_hand:
        row = np.zeros((*shape, size))
        row[..., 0], row[..., 1] = local
        row[..., body], row[..., body + 1] = np.negative(local[0]), np.negative(local[1])
        rows.append((row, push_object - push_hand, None))
    for index, (stiffness, damping) in enumerate(held):
        row = np.zeros((*shape, size))
        row[..., body], row[..., body + 1] = np.negative(stiffness), np.negative(damping)
        rows.append((row, push_object, index))
    for number, (row, push, index) in enumerate(rows):
        if computation_delay == 0:
            A[...] += push[..., :, None] * row[..., None, :]
            if index is not None:
                B[..., :, index] += push
                C[..., index, :] = row
                D[..., index, index] = 1.0
            continue
        newest = chain + number * computation_delay
        oldest = newest + computation_delay - 1
        A[..., newest, :] = row
        for place in range(newest + 1, oldest + 1):
            A[..., place, place - 1] = 1.0
        A[..., :, oldest] += push
        if index is not None:
            B[..., newest, index] += 1.0
            C[..., index, oldest] = 1.0
    A[..., :, body + 1] -= np.asarray(compensation)[..., None] * push_object

    translation = np.zeros(size)
    translation[body] = 1.0
    if has_hand:
        translation[0] = 1.0
    return Station(
        A=A,
        B=B,
        C=C,
        D=D,
        force_on_hand=push_hand,
        force_on_object=push_object,
        hand=0 if has_hand else None,
        body=body,
        translation=translation,
    )


def _common_shape(
    hand: tuple[Value, Value] | tuple[Value, Value, float] | None,
    local: tuple[Value, Value],
    object_mass: Value,
    compensation: Value,
    held: Sequence[tuple[Value, Value]],
) -> tuple[int, ...]:
    values: list[Value] = [*local, object_mass, compensation]
    values.extend(hand[:2] if hand else ())
    for pair in held:
        values.extend(pair)
    return np.broadcast_shapes(*(np.shape(value) for value in values))
