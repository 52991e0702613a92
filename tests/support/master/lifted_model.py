"""The single-axis systems of chapters 3 to 6 as lifted state-space models, in NumPy alone.

Written from the equations (3.1), (4.2), (4.3), (4.9), not from the master: masses under held
forces have the exact zero-order-hold discretisation; couplers read local states at T_c and what
crosses the network at T_t; one frame of N ticks is one matrix on the stacked state
``[x; held forward; held backward; sent forward (newest first); sent backward]``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

T = 1 / 1024
N = 8
HISTORY = 8
"""Packets that are remembered: the longest delay in samples."""

Matrix = NDArray[np.float64]
Fate = int | None
"""Delay of a packet in samples; ``None``: lost."""


@dataclass(frozen=True)
class System:
    """``force = on_state x + on_held h + external``; packets are linear in x and h as well."""

    masses: tuple[float, ...]
    on_state: Matrix
    """(masses, 2 masses)"""
    on_held: Matrix
    """(masses, forward + backward)"""
    forward: Matrix
    """Forward packet from the state: (forward, 2 masses)."""
    backward: Matrix
    """Backward packet from state and held forward packet: (backward, 2 masses + forward)."""


def position_velocity(mass: int, masses: int) -> Matrix:
    """Rows that pick position and velocity of one mass from the state."""
    rows = np.zeros((2, 2 * masses))
    rows[0, 2 * mass] = rows[1, 2 * mass + 1] = 1.0
    return rows


def centralized(*, m_h: float, m_o: float, k_1: float, k_2: float, b: float) -> System:
    """Masses hand 1, object, hand 2; hand 2's state goes forward to the server, its force back."""
    hand_1, thing, hand_2 = (position_velocity(i, 3) for i in range(3))
    gain_1, gain_2 = np.array([[k_1, b]]), np.array([[k_2, b]])
    coupler_1 = gain_1 @ (hand_1 - thing)
    coupler_2_local = -gain_2 @ thing
    coupler_2_held = np.hstack([gain_2, np.zeros((1, 1))])
    on_state = np.vstack([-coupler_1, coupler_1 + coupler_2_local, np.zeros((1, 6))])
    on_held = np.vstack([np.zeros((1, 3)), coupler_2_held, [[0.0, 0.0, 1.0]]])
    backward = -np.hstack([coupler_2_local, gain_2])
    return System((m_h, m_o, m_h), on_state, on_held, hand_2, backward)


def distributed(
    *, m_h: float, m_o: float, k_own: float, k_other: float, k_o: float, b: float, b_o: float
) -> System:
    """Masses hand 1, object 1, object 2, hand 2; each side sends hand and object."""
    hand_1, thing_1, thing_2, hand_2 = (position_velocity(i, 4) for i in range(4))
    own, other, between = np.array([[k_own, b]]), np.array([[k_other, b]]), np.array([[k_o, b_o]])
    coupler_1, coupler_2 = own @ (hand_1 - thing_1), own @ (hand_2 - thing_2)
    on_state = np.vstack(
        [
            -coupler_1,
            coupler_1 - (other + between) @ thing_1,
            coupler_2 - (other + between) @ thing_2,
            -coupler_2,
        ]
    )
    zero = np.zeros((1, 4))
    received = np.hstack([other, between])
    on_held = np.vstack(
        [
            np.zeros((1, 8)),
            np.hstack([zero, received]),
            np.hstack([received, zero]),
            np.zeros((1, 8)),
        ]
    )
    forward = np.vstack([hand_1, thing_1])
    backward = np.hstack([np.vstack([hand_2, thing_2]), np.zeros((4, 4))])
    return System((m_h, m_o, m_o, m_h), on_state, on_held, forward, backward)


def simulate(
    system: System,
    initial: Sequence[float],
    force: tuple[int, float, float],
    fates: tuple[Sequence[Fate], Sequence[Fate]],
    frames: int,
) -> Matrix:
    """States at every tick, shape (frames * N, 2 masses).

    ``force`` is (mass, newtons, from time); it is held over each tick. ``fates`` are the delays of
    the forward and backward packets of each frame, in samples.
    """
    count = len(system.masses)
    n_x, n_f, n_b = 2 * count, len(system.forward), len(system.backward)
    a, b_u = _discretise(system.masses)
    closed = a + b_u @ system.on_state
    held_in = b_u @ system.on_held

    # Lifting: x(j) = closed^j x + (sum of closed^i, i < j) held_in h + the forces of ticks < j.
    powers = [np.eye(n_x)]
    for _ in range(N):
        powers.append(closed @ powers[-1])
    sums = [sum(powers[:j], np.zeros((n_x, n_x))) for j in range(N + 1)]
    outputs = np.vstack([np.hstack([powers[j], sums[j] @ held_in]) for j in range(N + 1)])
    column = b_u[:, force[0]]
    forcing = np.zeros(((N + 1) * n_x, N))
    for j in range(1, N + 1):
        for i in range(j):
            forcing[j * n_x : (j + 1) * n_x, i] = powers[j - 1 - i] @ column

    x = np.array(initial, dtype=float)
    first_forward = system.forward @ x
    first_backward = system.backward @ np.concatenate([x, first_forward])
    stacked = np.concatenate(
        [
            x,
            first_forward,
            first_backward,
            np.tile(first_forward, HISTORY),
            np.tile(first_backward, HISTORY),
        ]
    )
    newest = [-1, -1]
    states = np.zeros((frames, N + 1, n_x))
    for frame in range(frames):
        choices = [_arrival(fates[way], newest[way], frame) for way in (0, 1)]
        for way in (0, 1):
            if choices[way] is not None:
                newest[way] = frame - choices[way]
        stacked = _network(system, choices[0], choices[1]) @ stacked
        ticks = np.arange(frame * N, frame * N + N)
        pushes = np.where(ticks * T >= force[2], force[1], 0.0)
        lifted = outputs @ stacked[: n_x + n_f + n_b] + forcing @ pushes
        states[frame] = lifted.reshape(N + 1, n_x)
        stacked[:n_x] = states[frame, N]
    return states[:, :N].reshape(frames * N, n_x)


def _discretise(masses: Sequence[float]) -> tuple[Matrix, Matrix]:
    count = len(masses)
    a = np.kron(np.eye(count), [[1.0, T], [0.0, 1.0]])
    b = np.zeros((2 * count, count))
    for i, mass in enumerate(masses):
        b[2 * i : 2 * i + 2, i] = T**2 / (2 * mass), T / mass
    return a, b


def _arrival(fates: Sequence[Fate], newest: int, frame: int) -> int | None:
    """How many frames old the packet is that arrives and is taken now; ``None``: nothing new."""
    arrived = [
        sent
        for sent in range(newest + 1, frame + 1)
        if fates[sent] is not None and sent + fates[sent] <= frame
    ]
    return frame - max(arrived) if arrived else None


def _network(system: System, forward: int | None, backward: int | None) -> Matrix:
    """What the start of a frame does to the stacked state: deliver, sample, remember."""
    n_x, n_f, n_b = 2 * len(system.masses), len(system.forward), len(system.backward)
    size = n_x + (n_f + n_b) * (1 + HISTORY)
    x = slice(0, n_x)
    h_f = slice(n_x, n_x + n_f)
    h_b = slice(h_f.stop, h_f.stop + n_b)
    s_f = h_b.stop
    s_b = s_f + HISTORY * n_f

    deliver_f = np.eye(size)
    if forward is not None:
        deliver_f[h_f] = 0.0
        if forward == 0:
            deliver_f[h_f, x] = system.forward
        else:
            start = s_f + (forward - 1) * n_f
            deliver_f[h_f, start : start + n_f] = np.eye(n_f)
    deliver_b = np.eye(size)
    if backward is not None:
        deliver_b[h_b] = 0.0
        if backward == 0:
            deliver_b[h_b, x] = system.backward[:, :n_x]
            deliver_b[h_b, h_f] = system.backward[:, n_x:]
        else:
            start = s_b + (backward - 1) * n_b
            deliver_b[h_b, start : start + n_b] = np.eye(n_b)
    remember = np.eye(size)
    remember[s_f : s_f + n_f] = 0.0
    remember[s_f : s_f + n_f, x] = system.forward
    remember[s_b : s_b + n_b] = 0.0
    remember[s_b : s_b + n_b, x] = system.backward[:, :n_x]
    remember[s_b : s_b + n_b, h_f] = system.backward[:, n_x:]
    for start, width in ((s_f, n_f), (s_b, n_b)):
        moved = slice(start + width, start + HISTORY * width)
        remember[moved] = 0.0
        remember[moved, start : start + (HISTORY - 1) * width] = np.eye((HISTORY - 1) * width)
    return remember @ deliver_b @ deliver_f
