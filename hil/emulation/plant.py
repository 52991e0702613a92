"""What an emulated device moves: the pantograph's dynamics, and a hand that holds or moves it.

The pantograph is our own model, the same that a scenario simulates; torque in, encoder counts out.
"""

from __future__ import annotations

from collections.abc import Mapping
from random import Random
from typing import Any, Protocol

from hil.emulation.model import SteppedModel
from hil.safety.linkage import Pair


class Body(Protocol):
    """A mechanism that is stepped tick by tick under joint torques."""

    def angle(self) -> Pair:
        """True joint angles (rad)."""
        ...

    def step(self, torque: Pair) -> None:
        """Advance one control tick under held joint torques (N.m)."""
        ...

    def start(self) -> None:
        """What the hand has planned begins now."""
        ...

    def close(self) -> None:
        """Free what it holds."""
        ...


class Hand:
    """A hand that holds its place: F = k (x_ref - x) - b v (N)."""

    def __init__(self, stiffness: float = 100.0, damping: float = 3.0) -> None:
        self.stiffness, self.damping = stiffness, damping
        self.reference: Pair | None = None

    @property
    def is_there(self) -> bool:
        """Whether anybody holds the handle."""
        return self.stiffness != 0.0 or self.damping != 0.0

    def force(self, position: Pair, velocity: Pair) -> Pair:
        """The force on the tip (N)."""
        if self.reference is None:
            self.reference = position
        return (
            self.stiffness * (self.reference[0] - position[0]) - self.damping * velocity[0],
            self.stiffness * (self.reference[1] - position[1]) - self.damping * velocity[1],
        )


class SimulatedPantograph:
    """The pantograph FMU with a hand at its tip.

    ``parameters`` are the FMU's. ``hand`` holds the handle; with ``operator``, parameters of the
    operator FMU, that one takes over from :meth:`start` on. ``gain`` is what motors give of what
    they are told, ``noise`` the standard deviation of what the encoders see (rad).
    """

    def __init__(
        self,
        parameters: Mapping[str, Any] | None = None,
        *,
        hand: Hand | None = None,
        operator: Mapping[str, Any] | None = None,
        step: float = 1 / 1024,
        gain: Pair = (1.0, 1.0),
        noise: float = 0.0,
    ) -> None:
        self._gain, self._noise, self._chance = gain, noise, Random(0)
        self._error: Pair = (0.0, 0.0)
        self._model = SteppedModel("pantograph", parameters or {})
        self._hand = hand or Hand()
        # Made now, because unpacking an FMU takes longer than a host waits for an answer.
        self._operator = SteppedModel("operator", operator) if operator is not None else None
        self._started = False
        self._step = step
        self.hand_force: Pair = (0.0, 0.0)
        """What the hand did to the tip in the last tick (N)."""

    def angle(self) -> Pair:
        """Joint angles (rad) as the encoders see them."""
        angle = self._model.pair("true_joint_angle")
        return angle[0] + self._error[0], angle[1] + self._error[1]

    def start(self) -> None:
        """The operator's time is zero now."""
        self._started = True

    def step(self, torque: Pair) -> None:
        """Advance one tick."""
        position, velocity = self._model.pair("tip_position"), self._model.pair("tip_velocity")
        self.hand_force = self._force(position, velocity)
        self._model.set("hand_force", self.hand_force)
        self._model.set("motor_torque", (self._gain[0] * torque[0], self._gain[1] * torque[1]))
        self._model.step(self._step)
        if self._noise:
            first, second = (self._chance.gauss(0.0, self._noise) for _ in range(2))
            self._error = (first, second)

    def close(self) -> None:
        """Free the models."""
        self._model.close()
        if self._operator is not None:
            self._operator.close()

    def _force(self, position: Pair, velocity: Pair) -> Pair:
        if self._operator is None or not self._started:
            return self._hand.force(position, velocity)
        self._operator.set("position", position)
        self._operator.set("velocity", velocity)
        force = self._operator.pair("force")
        self._operator.step(self._step)
        return force
