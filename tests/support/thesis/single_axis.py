"""An independent single-axis computation of the free-motion experiment, in plain NumPy.

User 1's hand is prescribed, user 2's is a free mass; both copies of the object are masses under
held forces. Nothing of the product is used.
"""

from __future__ import annotations

import numpy as np

T_C = 1.0 / 1024.0
RATIO = 8
OBJECT, HAND = 0.4, 0.1
K_11, K_12, K_O = (800.0, 3.0), (170.0, 3.0), (77.5, 10.0)
AMPLITUDE, FREQUENCY = 0.05, 2.0


def _pull(gains, towards, own):
    return gains[0] * (towards[0] - own[0]) + gains[1] * (towards[1] - own[1])


def net_force_amplitude(round_trip: int, compensation: float, seconds: float = 20.0) -> float:
    """Amplitude (N) at the sine's frequency of both users' forces on their copies, added up."""
    forward, backward = (round_trip + 1) // 2, round_trip // 2
    ticks = int(seconds / T_C)
    objects = np.zeros((2, 2))
    hand = np.zeros(2)
    net = np.zeros(ticks)
    up, down = [], []
    for k in range(ticks):
        t = k * T_C
        driven = AMPLITUDE * np.array([np.sin(FREQUENCY * t), FREQUENCY * np.cos(FREQUENCY * t)])
        if k % RATIO == 0:
            up.append((driven.copy(), objects[0].copy()))
            down.append((hand.copy(), objects[1].copy()))
            held_1 = down[max(len(down) - 1 - backward, 0)]
            held_2 = up[max(len(up) - 1 - forward, 0)]
        one = _pull(K_11, driven, objects[0])
        two = _pull(K_11, hand, objects[1])
        net[k] = one + two
        forces = (
            one + _pull(K_12, held_1[0], objects[0]) + _pull(K_O, held_1[1], objects[0]),
            two + _pull(K_12, held_2[0], objects[1]) + _pull(K_O, held_2[1], objects[1]),
        )
        for i in range(2):
            acceleration = (forces[i] - compensation * objects[i, 1]) / OBJECT
            objects[i, 0] += T_C * objects[i, 1] + 0.5 * T_C**2 * acceleration
            objects[i, 1] += T_C * acceleration
        acceleration = -two / HAND
        hand[0] += T_C * hand[1] + 0.5 * T_C**2 * acceleration
        hand[1] += T_C * acceleration
    window = int(2 * np.pi / FREQUENCY * 3 / T_C)
    phase = FREQUENCY * T_C * np.arange(ticks - window, ticks)
    basis = np.stack([np.ones(window), np.cos(phase), np.sin(phase)], axis=1)
    fit = np.linalg.lstsq(basis, net[-window:], rcond=None)[0]
    return float(np.hypot(fit[1], fit[2]))
