"""A scenario with people's hands in it: what has to lie over one that emulates its users.

Each station whose users are ``operator`` models gets a ``pointer``, and those operators track it;
until somebody moves one they stay emulated: they touch the box and press as the scenario has it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import cos, sin
from typing import Any

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import quantity
from cosim.live.mailbox import FINGERS
from cosim.scenario import Scenario, ScenarioComponent

POINTER, PANEL = "cosim.live.pointer:Pointer", "cosim.live.panel:KnobPanel"
CROSSFADE = "cosim.live.crossfade:Crossfade"
OPERATOR, DEVICE = "operator", "pantograph"
FORWARD, REACH = 0.77, 0.27
"""Where the middle of a pantograph's workspace lies in front of its motors, and how far from there
a finger may be led, in the length of its stretched links."""
DEFAULT_REACH = 0.07
"""Where the device's geometry is not known (m)."""


@dataclass(frozen=True, slots=True)
class User:
    """One person's place: a station, the component of their pointer, their emulated fingers."""

    station: str
    pointer: str
    operators: tuple[str, ...]


def users_of(scenario: Scenario) -> list[User]:
    """Who can be played, at most two fingers each.

    Raises:
        InputError: nobody, because no user of the scenario is an ``operator``.
    """
    operators: dict[str, list[str]] = {}
    for name, component in scenario.components.items():
        if component.is_bundled and component.source == OPERATOR:
            operators.setdefault(component.station, []).append(name)
    if not operators:
        raise InputError(
            f"nobody can take part in {scenario.name}: none of its components is an "
            f"'{OPERATOR}', whose place a hand could take; try 'cohaptic play two_users_box'."
        )
    return [
        User(station, f"pointer_{station}", tuple(names[:FINGERS]))
        for station, names in operators.items()
    ]


def pointers_of(scenario: Scenario) -> list[str]:
    """The pointers of a take's scenario, and the panels of its knobs.

    Raises:
        InputError: there is none.
    """
    found = [n for n, p in scenario.components.items() if p.source in {POINTER, PANEL}]
    if not found:
        raise InputError(
            f"{scenario.file} is no take of 'cohaptic play': there is no pointer in it."
        )
    return found


def with_hands(scenario: Scenario, users: list[User]) -> dict[str, Any]:
    """The document to lay over the scenario, as YAML holds it."""
    components: dict[str, Any] = {}
    connections: list[str] = []
    for user in users:
        first = scenario.components[user.operators[0]]
        reach = [_reach(scenario, name) for name in user.operators]
        reach += reach[-1:] * (FINGERS - len(reach))
        components[user.pointer] = {
            "python": POINTER,
            "station": user.station,
            "rate": first.rate_name or float(first.rate),
            "parameters": {
                "reach": min(each[2] for each in reach),
                **{f"centre_{n}": list(each[:2]) for n, each in enumerate(reach, 1)},
            },
        }
        for number, name in enumerate(user.operators, 1):
            components[name] = {"parameters": _tracked(scenario.components[name])}
            connections.append(f"{user.pointer}.position_{number} -> {name}.target_position")
            connections += [
                f"{user.pointer}.{what} -> {name}.target_{what}"
                for what in ("valid", "count", "age")
            ]
    # What a scenario expects of its emulated users nobody promises of people.
    return {"components": components, "connections": connections, "expect": None}


def _tracked(operator: ScenarioComponent) -> dict[str, Any]:
    touches = operator.parameters.get("trajectory") in {2, "minimum_jerk"}
    return {
        "trajectory": "tracked",
        "via_count": min(1, int(operator.parameters.get("via_count", 0))) if touches else 0,  # pyright: ignore[reportArgumentType]
    }


def _reach(scenario: Scenario, operator: str) -> tuple[float, float, float]:
    """Middle and radius (m, world frame) of where an operator's finger can be led."""
    device = _device(scenario, operator)
    if device is None:
        start: Any = scenario.components[operator].parameters.get("initial_position", (0.0, 0.0))
        x, y = (float(quantity(each, "m")) for each in start)
        return x, y, DEFAULT_REACH
    lengths = _lengths(device.parameters)
    stretched = lengths["proximal_length"] + lengths["distal_length"]
    x, y = 0.5 * lengths["base_distance"], FORWARD * stretched
    base_x, base_y, turn = (
        _number(device.parameters, f"base_{k}", unit)
        for k, unit in (("x", "m"), ("y", "m"), ("angle", "rad"))
    )
    return (
        base_x + cos(turn) * x - sin(turn) * y,
        base_y + sin(turn) * x + cos(turn) * y,
        REACH * stretched,
    )


def _device(scenario: Scenario, operator: str) -> ScenarioComponent | None:
    """The pantograph that an operator pushes."""
    for connection in scenario.connections:
        if connection.source.component == operator:
            target = scenario.components.get(connection.target.component)
            if target is not None and target.is_bundled and target.source == DEVICE:
                return target
    return None


def _lengths(parameters: Mapping[str, Any]) -> dict[str, float]:
    from fmus.shared.mechanism.device import presets

    preset = 1 if parameters.get("device") in {1, "haply"} else 0
    found: dict[str, float] = {}
    for name in ("proximal_length", "distal_length", "base_distance"):
        given = _number(parameters, name, "m", -1.0)
        found[name] = given if given != -1.0 else presets("GEOMETRY")[name][preset]
    return found


def _number(parameters: Mapping[str, Any], name: str, unit: str, default: float = 0.0) -> float:
    return float(quantity(parameters.get(name, default), unit))
