"""What an emulated device moves: the pantograph's dynamics, and a hand that holds or moves it.

The pantograph is our own model, the same that a scenario simulates; torque in, encoder counts out.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import pi
from typing import Any, Protocol

from hil.linkage import Pair


class Body(Protocol):
    """A mechanism that is stepped tick by tick under joint torques."""

    def angle(self) -> Pair:
        """True joint angles (rad)."""
        ...

    def step(self, torque: Pair) -> None:
        """Advance one control tick under held joint torques (N.m)."""
        ...


class Hand:
    """A hand that holds its place: F = k (x_ref - x) - b v (N), x_ref moving as told."""

    def __init__(self, stiffness: float = 100.0, damping: float = 3.0) -> None:
        self.stiffness, self.damping = stiffness, damping
        self.reference: Pair | None = None

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """The force on the tip (N)."""
        if self.reference is None:
            self.reference = position
        return (
            self.stiffness * (self.reference[0] - position[0]) - self.damping * velocity[0],
            self.stiffness * (self.reference[1] - position[1]) - self.damping * velocity[1],
        )


class SimulatedPantograph:
    """The pantograph model with a hand at its tip.

    ``parameters`` are the model's; ``hand`` gives the force at the tip from position and velocity.
    """

    def __init__(
        self,
        parameters: Mapping[str, Any] | None = None,
        *,
        hand: Hand | None = None,
        step: float = 1 / 1024,
    ) -> None:
        from fmus.development import Instance

        self._model = Instance("pantograph", **(parameters or {}))
        self._model.initialise()
        self._hand = hand or Hand()
        self._step = step

    def angle(self) -> Pair:
        """True joint angles (rad)."""
        first, second = self._model["true_joint_angle"]
        return float(first), float(second)

    def step(self, torque: Pair) -> None:
        """Advance one tick."""
        x, y = (float(value) for value in self._model["tip_position"])
        vx, vy = (float(value) for value in self._model["tip_velocity"])
        self._model["hand_force"] = self._hand.force((x, y), (vx, vy))
        self._model["motor_torque"] = torque
        self._model.step(self._step)


class Encoders:
    """Incremental encoders: counts since power-on, zero at the pose of power-on."""

    def __init__(self, counts_per_turn: int, start: Pair) -> None:
        self.counts_per_turn = counts_per_turn
        self._start = start

    def count(self, angle: Pair) -> tuple[int, int]:
        """Whole counts for shaft angles (rad)."""
        per = self.counts_per_turn / (2 * pi)
        return round((angle[0] - self._start[0]) * per), round((angle[1] - self._start[1]) * per)
