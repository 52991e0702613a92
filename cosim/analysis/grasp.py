"""The single-axis model of a planar scenario: one finger a user, all of them holding the box.

The users are the scenario's ``distributed_workstation`` components; their couplers, masses, rates
and the delay between them come from the scenario, and what it leaves open from the FMU's own start
values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from typing import Literal

import numpy as np

from cosim.analysis.parameter import parameter
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent
from cosim.theory.models.mass_spring_damper import Distributed
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.numerics import Real

WORKSTATION = "distributed_workstation"

Axis = Literal["normal", "tangential", "rotation"]


@dataclass(frozen=True, slots=True)
class Grasp:
    """Who holds the box, and when they hear of each other.

    ``timing.delay`` takes whole network samples: a delay between two is rounded up, which is the
    safe side for stability, or down, which is that of a cautious compensation. ``ways`` are the
    delays forward and backward as they are, in samples.
    """

    workstations: tuple[ScenarioComponent, ...]
    timing: Timing
    ways: tuple[Fraction, Fraction]

    def model(self, axis: Axis) -> Distributed:
        """One axis of the box with one finger a user pressing on it (figure 4.4).

        For rotation the masses are the box's inertias and nobody holds it: where a finger touches
        is not known beforehand (thesis, section 6.1, the simplified model).
        """
        users = len(self.workstations)
        others = 1.0 - np.eye(users)
        if axis == "rotation":
            object_mass = self._each("inertia")
            stiffness = self._each("coupling_rotational_stiffness")
            damping = self._each("coupling_rotational_damping")
            axis = "normal"
            present = (False,) * users
        else:
            object_mass = self._each("mass")
            stiffness, damping = self._each("coupling_stiffness"), self._each("coupling_damping")
            present = (True,) * users
        return Distributed(
            present=present,
            hand_mass=self._each("hand_mass"),
            hand_damping=np.zeros(users),
            object_mass=object_mass,
            local_stiffness=self._each(f"local_{axis}_stiffness"),
            local_damping=self._each(f"local_{axis}_damping"),
            remote_stiffness=others * self._each(f"remote_{axis}_stiffness")[:, None],
            remote_damping=others * self._each(f"remote_{axis}_damping")[:, None],
            object_stiffness=others * stiffness[:, None],
            object_damping=others * damping[:, None],
            compensation=np.zeros(users),
        )

    def _each(self, name: str) -> Real:
        return np.array([parameter(part, name) for part in self.workstations])


def find_grasp(scenario: Scenario, *, earliest: bool = False) -> Grasp:
    """The distributed workstations of a scenario and the timing between them.

    ``earliest`` rounds delays down and takes the shortest; else they are rounded up.

    Raises:
        InputError: there are fewer than two, nothing joins them, or, unless ``earliest``, their
            delays differ.
    """
    workstations = tuple(
        part
        for part in scenario.components.values()
        if part.is_bundled and part.source == WORKSTATION
    )
    if len(workstations) < 2:
        raise InputError(
            f"the scenario has {len(workstations)} distributed workstations: the network adds "
            "damping only between two or more.",
            scenario.locate(("components",)),
        )
    control = {part.period for part in workstations}
    if len(control) > 1:
        raise InputError(
            "the distributed workstations run at different rates; the theory takes one.",
            scenario.locate(("components", workstations[1].name, "rate")),
        )
    return Grasp(workstations, *_timing(scenario, workstations, control.pop(), earliest=earliest))


def _timing(
    scenario: Scenario,
    workstations: tuple[ScenarioComponent, ...],
    control: int,
    *,
    earliest: bool,
) -> tuple[Timing, tuple[Fraction, Fraction]]:
    names = {part.station: part.name for part in workstations}
    delays: dict[tuple[str, str], Fraction] = {}
    periods: set[int] = set()
    for connection in scenario.connections:
        if connection.via is None:
            continue
        source = scenario.components.get(connection.source.component)
        target = scenario.components.get(connection.target.component)
        if source is None or target is None or {source.name, target.name} - set(names.values()):
            continue
        channel = scenario.channels[connection.via]
        direction = channel.direction(source.station, target.station)
        periods.add(channel.period)
        delays[source.station, target.station] = Fraction(direction.delay.ticks, channel.period)
    missing = [pair for pair in permutations(names, 2) if pair not in delays]
    if missing:
        sender, receiver = missing[0]
        raise InputError(
            f"nothing goes from {names[sender]} to {names[receiver]} through a channel.",
            scenario.locate(("connections",)),
        )
    if len(periods) > 1:
        raise InputError(
            "the workstations' channels have different rates; the theory takes one.",
            scenario.locate(("channels",)),
        )
    order = list(names)
    ahead = [delay for (a, b), delay in delays.items() if order.index(a) < order.index(b)]
    back = [delay for (a, b), delay in delays.items() if order.index(a) > order.index(b)]
    if not earliest and (len(set(ahead)) > 1 or len(set(back)) > 1):
        raise InputError(
            "the workstations hear of each other after different delays; the theory takes one "
            "there and one back.",
            scenario.locate(("channels",)),
        )
    forward, backward = min(ahead), min(back)
    rounded = math.floor if earliest else math.ceil
    timing = Timing(
        control_period=Fraction(control) / scenario.base_rate,
        ratio=Fraction(periods.pop(), control),
        delay=PathDelay(forward=rounded(forward), backward=rounded(backward)),
    )
    return timing, (forward, backward)
