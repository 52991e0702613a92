"""Two worlds at one pair of fingers: the torques of the one give way to those of the other.

Both worlds step all the time with the same measurements; a scenario connects the torques that each
asks for, and passes on what is shown here. ``position`` says which is wanted and may be turned;
``share`` follows it at a bounded rate, so that a hand on the device feels no step.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cosim.base.component import Causality, Cells, Component, Setup, Variable
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning

FINGERS = 2


def _torque(name: str, causality: Causality, text: str, meaning: Meaning | None) -> Variable:
    return Variable(
        name=name,
        causality=causality,
        unit="N.m",
        shape=(2,),
        start=0.0,
        description=text,
        meaning=meaning,
    )


def _finger(number: int) -> tuple[Variable, ...]:
    return (
        _torque(
            f"first_{number}",
            Causality.INPUT,
            f"Motor torques that the first world asks for at finger {number}",
            Meaning.FADED_FIRST,
        ),
        _torque(
            f"second_{number}",
            Causality.INPUT,
            f"Motor torques that the second world asks for at finger {number}",
            Meaning.FADED_SECOND,
        ),
        _torque(
            f"torque_{number}",
            Causality.OUTPUT,
            f"(1 - share) first_{number} + share second_{number}",
            None,
        ),
    )


VARIABLES = (
    *(variable for number in range(1, FINGERS + 1) for variable in _finger(number)),
    Variable(
        name="position",
        causality=Causality.PARAMETER,
        variability="tunable",
        unit="1",
        start=0.0,
        minimum=0.0,
        maximum=1.0,
        description="Where the share goes: 0 is the first world, 1 the second",
    ),
    Variable(
        name="fade_time",
        causality=Causality.PARAMETER,
        variability="fixed",
        unit="s",
        start=0.5,
        description="How long the share takes from 0 to 1",
    ),
    Variable(
        name="share",
        causality=Causality.OUTPUT,
        unit="1",
        start=0.0,
        description="Share of the second world",
        meaning=Meaning.FADED_SHARE,
    ),
)


class Crossfade(Component):
    """Begins where ``position`` stands, and moves towards it by one step of the fade a period."""

    @property
    def variables(self) -> Sequence[Variable]:
        """Torques of both worlds, what becomes of them, and which is wanted."""
        return VARIABLES

    @property
    def dependencies(self) -> Mapping[str, Sequence[str]]:
        """A torque is that of its finger in both worlds; the share is of the past alone."""
        return {f"torque_{n}": (f"first_{n}", f"second_{n}") for n in range(1, FINGERS + 1)}

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Begin in the world that is wanted.

        Raises:
            InputError: the fade takes no time, which would be a step.
        """
        seconds = float(setup.parameters.get("fade_time", 0.5))
        if not seconds > 0.0:
            raise InputError(
                f"{setup.name}: fade_time is {seconds:g} s; a change without any time is a step of "
                "the torques: give it one above 0 (0.5 s is usual)."
            )
        self._most = setup.period * setup.tick[0] / setup.tick[1] / seconds
        self._pairs = [
            (inputs[f"first_{n}"], inputs[f"second_{n}"], outputs[f"torque_{n}"])
            for n in range(1, FINGERS + 1)
        ]
        self._shown = outputs["share"]
        self._position = inputs.get("position")
        self._fixed = float(setup.parameters.get("position", 0.0))
        self._share = self._fixed

    def evaluate(self, tick: int) -> None:
        """Blend; a world of no share has no part, not even one that is no number."""
        share = self._share
        self._shown[0] = share
        for first, second, torque in self._pairs:
            if share <= 0.0:
                torque[:] = first
            elif share >= 1.0:
                torque[:] = second
            else:
                torque[0] = (1.0 - share) * first[0] + share * second[0]
                torque[1] = (1.0 - share) * first[1] + share * second[1]

    def step(self, tick: int) -> None:
        """Go on towards what is wanted."""
        wanted = self._fixed if self._position is None else float(self._position[0])
        way = wanted - self._share
        self._share = (
            wanted
            if abs(way) <= self._most
            else self._share + (self._most if way > 0.0 else -self._most)
        )

    def save(self) -> Any:
        """How far the fade is."""
        return self._share

    def load(self, values: Any) -> None:
        """Go on from there."""
        self._share = float(values)
