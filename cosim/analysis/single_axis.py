"""A single-axis scenario (hands, objects, virtual couplers) as a loop of chapters 3 to 6.

What couples what is read from the connections, not from names. Users are numbered by station: the
object's own station first in a centralized scenario, otherwise as the hands are written.
"""

from __future__ import annotations

from dataclasses import dataclass

from cosim.analysis.parameter import parameter
from cosim.analysis.single_axis_parts import Parts
from cosim.analysis.ties import (
    Tie,
)
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent
from cosim.theory.models.parameters import Architecture
from cosim.theory.models.timing import Timing


@dataclass(frozen=True, slots=True)
class ScenarioLoop:
    """The loop that a scenario describes.

    Attributes:
        architecture: single, centralized or distributed.
        users: how many hands.
        values: every parameter by its most specific name, SI units.
        timing: rates and the fixed delays.
        notes: what the theory leaves out or rounds.
    """

    architecture: Architecture
    users: int
    values: dict[str, float]
    timing: Timing
    notes: tuple[str, ...]


def read_single_axis(scenario: Scenario) -> ScenarioLoop:
    """Read a single-axis scenario.

    Raises:
        InputError: where the scenario has other parts than hands, objects and virtual couplers in
            its loop, or they are joined in a way that chapters 3 to 6 do not know.
    """
    parts = Parts(scenario)
    hands, objects, ties = parts.hands, parts.objects, parts.ties()
    if not hands or not objects:
        raise InputError(
            "The theory reads scenarios of workstations that share a box, and single-axis ones: "
            "hands and objects joined by virtual couplers (FMUs hand, object, virtual_coupler), as "
            "in scenarios/single_axis_distributed.yaml.",
            scenario.locate(("components",)),
        )
    distributed = len(objects) > 1
    numbers = _numbers(scenario, hands, objects, distributed=distributed)
    parts.refuse_other_joints(ties, numbers, distributed=distributed)
    values = parts.wall()
    for hand in hands:
        values[f"m_h{numbers[hand.name]}"] = parameter(hand, "mass")
        values[f"b_h{numbers[hand.name]}"] = 0.0
    for body in objects:
        suffix = str(numbers[body.name]) if distributed else ""
        values[f"m_o{suffix}"] = parameter(body, "mass")
        values[f"b_c{suffix}"] = parameter(body, "compensation")
    for name in _couplers(distributed=distributed, users=len(hands)):
        values[f"k_{name}"] = values[f"b_{name}"] = 0.0
    for tie in ties:
        name = _name_of(tie, numbers, {body.name for body in objects}, distributed=distributed)
        values[f"k_{name}"] = parameter(tie.coupler, "stiffness")
        values[f"b_{name}"] = parameter(tie.coupler, "damping")
    architecture: Architecture = "distributed" if distributed else "centralized"
    if len(hands) == 1 and not distributed:
        architecture = "single"
        values["k"], values["b"] = values.pop("k_1"), values.pop("b_1")
    notes: list[str] = []
    timing = parts.timing(numbers, notes, distributed=distributed)
    return ScenarioLoop(architecture, len(hands), values, timing, tuple(notes))


def paths_of_leaves(scenario: Scenario) -> dict[str, tuple[str, ...]]:
    """The scenario's paths behind each of the thesis's most specific names.

    Raises:
        InputError: as ``read_single_axis``.
    """
    parts = Parts(scenario)
    hands, objects, ties = parts.hands, parts.objects, parts.ties()
    distributed = len(objects) > 1
    numbers = _numbers(scenario, hands, objects, distributed=distributed)
    found: dict[str, list[str]] = {}

    def name(leaf: str, part: ScenarioComponent, parameter: str) -> None:
        path = f"components.{part.name}.parameters.{parameter}"
        found.setdefault(leaf, []).append(path)

    for hand in hands:
        name(f"m_h{numbers[hand.name]}", hand, "mass")
    for body in objects:
        suffix = str(numbers[body.name]) if distributed else ""
        name(f"m_o{suffix}", body, "mass")
        name(f"b_c{suffix}", body, "compensation")
        name("k_w", body, "wall_stiffness")
        name("b_w", body, "wall_damping")
    names = {body.name for body in objects}
    alone = len(hands) == 1 and not distributed
    for tie in ties:
        subscript = _name_of(tie, numbers, names, distributed=distributed)
        suffix = "" if alone else f"_{subscript}"
        name(f"k{suffix}", tie.coupler, "stiffness")
        name(f"b{suffix}", tie.coupler, "damping")
    return {leaf: tuple(paths) for leaf, paths in found.items()}


def _numbers(
    scenario: Scenario,
    hands: list[ScenarioComponent],
    objects: list[ScenarioComponent],
    *,
    distributed: bool,
) -> dict[str, int]:
    """Users are numbered by station: the object's own first, or as the hands are written."""
    if distributed:
        return _distributed_users(scenario, hands, objects)
    home = objects[0].station
    order = sorted(hands, key=lambda hand: hand.station != home)
    return {hand.name: place for place, hand in enumerate(order, start=1)}


def _couplers(*, distributed: bool, users: int) -> list[str]:
    numbers = range(1, users + 1)
    if not distributed:
        return [str(m) for m in numbers]
    return [f"{m}{r}" for m in numbers for r in numbers] + [f"o{m}" for m in numbers]


def _name_of(tie: Tie, numbers: dict[str, int], objects: set[str], *, distributed: bool) -> str:
    """The thesis's subscript of a coupler."""
    if not distributed:
        return str(numbers[tie.other])
    if tie.other in objects:
        return f"o{numbers[tie.own]}"
    return f"{numbers[tie.own]}{numbers[tie.other]}"


def _distributed_users(
    scenario: Scenario, hands: list[ScenarioComponent], objects: list[ScenarioComponent]
) -> dict[str, int]:
    by_station = {hand.station: place for place, hand in enumerate(hands, start=1)}
    stations = sorted(body.station for body in objects)
    if stations != sorted(by_station) or len(by_station) != len(hands):
        raise InputError(
            "A distributed scenario has one hand and one copy of the object at every station.",
            scenario.locate(("components",)),
        )
    return {part.name: by_station[part.station] for part in (*hands, *objects)}
