"""The intent predictor on many tracks at once, written apart from the C of the workstations.

A coordinate rests, and drifts, or moves with an acceleration that decays; two Kalman filters at
packet rate are mixed by how likely each is (Blom and Bar-Shalom, IEEE Trans. Automatic Control
33(8), 1988; the decay after Singer, IEEE Trans. Aerospace and Electronic Systems 6(4), 1970).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from fmus.shared.world.intent import PARAMETERS

Real = NDArray[np.float64]

CERTAIN = 700.0
"""A logarithm of odds beyond which nothing changes any more."""


@dataclass(frozen=True, slots=True)
class Tuning:
    """The numbers of ``predictor: intent``, SI; see ``fmus.shared.world.intent``."""

    acceleration: float
    decay: float
    drift: float
    position_noise: float
    velocity_noise: float
    start_rate: float
    stop_rate: float

    @staticmethod
    def default() -> Tuning:
        """What the workstations start with."""
        return Tuning(**{name: start for name, (start, _, _) in PARAMETERS.items()})

    @property
    def names(self) -> tuple[str, ...]:
        """The names in order."""
        return tuple(one.name for one in fields(self))

    def scaled(self, logarithms: Real) -> Tuning:
        """Every number times e to the power of its own."""
        values = asdict(self)
        return replace(
            self,
            **{
                name: float(values[name] * np.exp(power))
                for name, power in zip(self.names, logarithms, strict=True)
            },
        )


@dataclass(frozen=True, slots=True)
class Beliefs:
    """What is believed after each packet.

    Attributes:
        rest: position of the hand if it rests, m, shape (packets, tracks).
        move: position, velocity and acceleration if it moves, shape (packets, tracks, 3).
        moving: how likely it moves, shape (packets, tracks).
    """

    rest: Real
    move: Real
    moving: Real

    def ahead(self, tuning: Tuning, time: float) -> tuple[Real, Real]:
        """Position (m) and velocity (m/s) after ``time`` seconds, shape (packets, tracks)."""
        to_position, to_velocity, _ = _decay(tuning, time)
        x, v, a = np.moveaxis(self.move, -1, 0)
        further = x + time * v + to_position * a
        position = (1.0 - self.moving) * self.rest + self.moving * further
        return position, self.moving * (v + to_velocity * a)


def beliefs(tuning: Tuning, position: Real, velocity: Real, period: float) -> Beliefs:
    """Listen to packets that come every ``period`` seconds.

    Args:
        tuning: the filter's numbers.
        position: m, shape (packets, tracks).
        velocity: m/s, of the same shape.
        period: s.
    """
    packets, tracks = position.shape
    noise = np.diag([tuning.position_noise**2, tuning.velocity_noise**2])
    mean = np.zeros((2, tracks, 3))
    mean[:, :, 0], mean[:, :, 1] = position[0], velocity[0]
    first = np.diag([noise[0, 0], noise[1, 1], tuning.acceleration**2])
    spread = np.broadcast_to(first, (2, tracks, 3, 3)).copy()
    moving = np.full(tracks, 0.5)
    step, added = _models(tuning, period)
    start = 1.0 - np.exp(-tuning.start_rate * period)
    stop = 1.0 - np.exp(-tuning.stop_rate * period)
    found = Beliefs(
        np.zeros((packets, tracks)), np.zeros((packets, tracks, 3)), np.zeros((packets, tracks))
    )
    found.rest[0], found.move[0], found.moving[0] = mean[0, :, 0], mean[1], moving
    for packet in range(1, packets):
        share = np.stack([(1 - start) * (1 - moving) + stop * moving, np.zeros(tracks)])
        share[1] = 1.0 - share[0]
        foreign = np.stack([stop * moving, start * (1 - moving)]) / share
        mean, spread = _mixed(mean, spread, foreign)
        mean = np.einsum("mij,mtj->mti", step, mean)
        spread = step[:, None] @ spread @ step[:, None].swapaxes(-1, -2) + added[:, None]
        seen = np.stack([position[packet], velocity[packet]], axis=-1)
        mean, spread, likelihood = _corrected(mean, spread, seen, noise)
        odds = np.exp(np.minimum(likelihood[0] - likelihood[1], CERTAIN))
        moving = share[1] / (share[1] + share[0] * odds)
        found.rest[packet], found.move[packet] = mean[0, :, 0], mean[1]
        found.moving[packet] = moving
    return found


def _decay(tuning: Tuning, time: float) -> tuple[float, float, float]:
    """What an acceleration does in a time: to position, to velocity, and what is left of it."""
    kept = float(np.exp(-time / tuning.decay))
    to_velocity = tuning.decay * (1.0 - kept)
    return tuning.decay * (time - to_velocity), to_velocity, kept


def _models(tuning: Tuning, period: float) -> tuple[Real, Real]:
    """Both models' step, shape (2, 3, 3), and what it adds to the covariance."""
    to_position, to_velocity, kept = _decay(tuning, period)
    move = [[1.0, period, to_position], [0.0, 1.0, to_velocity], [0.0, 0.0, kept]]
    step = np.array([np.diag([1.0, 0.0, 0.0]), move])
    added = np.zeros((2, 3, 3))
    added[0, 0, 0] = (tuning.drift * period) ** 2
    added[1, 2, 2] = tuning.acceleration**2 * (1.0 - kept**2)
    return step, added


def _mixed(mean: Real, spread: Real, foreign: Real) -> tuple[Real, Real]:
    """Each model's belief with its share of the other one's."""
    weight = foreign[:, :, None]
    mix = (1.0 - weight) * mean + weight * mean[::-1]

    def outer(apart: Real) -> Real:
        return apart[..., :, None] * apart[..., None, :]

    own, other = spread + outer(mean - mix), spread[::-1] + outer(mean[::-1] - mix)
    return mix, (1.0 - weight[..., None]) * own + weight[..., None] * other


def _corrected(mean: Real, spread: Real, seen: Real, noise: Real) -> tuple[Real, Real, Real]:
    """Beliefs after a packet, and the logarithm of how likely it was (up to a constant)."""
    expected = spread[..., :2, :2] + noise
    inverse = np.linalg.inv(expected)
    error = seen - mean[..., :2]
    gain = spread[..., :, :2] @ inverse
    distance = np.einsum("mti,mtij,mtj->mt", error, inverse, error)
    likelihood = -0.5 * (distance + np.log(np.linalg.det(expected)))
    mean = mean + np.einsum("mtij,mtj->mti", gain, error)
    return mean, spread - gain @ spread[..., :2, :], likelihood
