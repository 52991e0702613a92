"""What an emulated device moves: the pantograph's dynamics, and a hand that holds or moves it.

The pantograph is our own model, the same that a scenario simulates; torque in, encoder counts out.
"""

from __future__ import annotations

from collections.abc import Mapping
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
    operator FMU, that one takes over from :meth:`start` on.
    """

    def __init__(
        self,
        parameters: Mapping[str, Any] | None = None,
        *,
        hand: Hand | None = None,
        operator: Mapping[str, Any] | None = None,
        step: float = 1 / 1024,
    ) -> None:
        self._model = SteppedModel("pantograph", parameters or {})
        self._hand = hand or Hand()
        # Made now, because unpacking an FMU takes longer than a host waits for an answer.
        self._operator = SteppedModel("operator", operator) if operator is not None else None
        self._started = False
        self._step = step
        self.hand_force: Pair = (0.0, 0.0)
        """What the hand did to the tip in the last tick (N)."""

    def angle(self) -> Pair:
        """True joint angles (rad)."""
        return self._model.pair("true_joint_angle")

    def start(self) -> None:
        """The operator's time is zero now."""
        self._started = True

    def step(self, torque: Pair) -> None:
        """Advance one tick."""
        position, velocity = self._model.pair("tip_position"), self._model.pair("tip_velocity")
        self.hand_force = self._force(position, velocity)
        self._model.set("hand_force", self.hand_force)
        self._model.set("motor_torque", torque)
        self._model.step(self._step)

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
