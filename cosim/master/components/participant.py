"""A component that was read and checked, and where each run gets its own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from cosim import scenario as scenarios
from cosim.base.component import Causality, Component, Played, Setup
from cosim.base.counter import stream_key
from cosim.base.errors import InputError
from cosim.master.components.interface import Interface
from cosim.master.fmu.description import FmuDescription
from cosim.scenario import Scenario

Values = dict[str, list[Any]]


Factory = Callable[[scenarios.ScenarioComponent], Component]
"""Makes the component of a kind that is handed in."""


@dataclass  # no slots: see ``cosim.base.changed``
class Participant:
    """A component that was read and checked, but does not run yet."""

    name: str
    period: int
    interface: Interface
    parameters: Values
    start: Values
    fmu: FmuDescription | None = None
    substeps: int = 1
    component: Component | None = None
    """What was asked for its variables; a run takes its own from ``supply``."""
    supply: Supply | None = None
    methods: frozenset[str] = field(default_factory=frozenset[str])
    played: Played | None = None
    is_isolated: bool = False
    """fmu: whether it gets a process of its own."""
    notes: tuple[str, ...] = ()
    """What is worth telling of it."""


class Supply:
    """Gives each run a component of its own: first the one that was read, then others like it.

    One that was handed in, or that stands for a device, there is only once.
    """

    def __init__(self, name: str, first: Component, make: Callable[[], Component] | None) -> None:
        self._name = name
        self._first: Component | None = first
        self._make = make

    def take(self) -> Component:
        """A component that no other run has.

        Raises:
            InputError: there is no other one.
        """
        first, self._first = self._first, None
        if first is not None:
            return first
        if self._make is None:
            raise InputError(
                f"{self._name} exists only once and has served a run: assemble the scenario again "
                "with another one."
            )
        return self._make()


def setup_of(scenario: Scenario, participant: Participant) -> Setup:
    """What a Python component is told; its seed follows from its name."""
    tick = 1 / scenario.base_rate
    values = {
        name: elements[0] if not participant.interface.variables[name].shape else tuple(elements)
        for name, elements in participant.parameters.items()
        if name in participant.interface.variables
    }
    declared = {
        variable.name: variable.start
        for variable in participant.interface.variables.values()
        if variable.causality is Causality.PARAMETER and variable.start is not None
    }
    written = scenario.components[participant.name].parameters
    return Setup(
        name=participant.name,
        parameters={**declared, **written, **values},
        tick=(tick.numerator, tick.denominator),
        period=participant.period,
        seed=stream_key(scenario.seed, "component", participant.name),
        start_time=float(scenario.start_time),
    )
