"""A single-axis scenario (hands, objects, virtual couplers) as a loop of chapters 3 to 6.

What couples what is read from the connections, not from names. Users are numbered by station: the
object's own station first in a centralized scenario, otherwise as the hands are written.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from cosim.analysis.parameter import parameter
from cosim.analysis.ties import (
    Tie,
    refuse_double_ties,
    refuse_other_copies,
    refuse_other_places,
    wires_of,
)
from cosim.analysis.wires import refuse_other_steps, refuse_other_wires
from cosim.base.errors import InputError
from cosim.scenario import Connection, Direction, Scenario, ScenarioComponent
from cosim.theory.models.parameters import Architecture
from cosim.theory.models.timing import PathDelay, Timing

WITHOUT_CHANCE = (
    "Loss, jitter and traces of the channel are left out here; theory loss and theory design take "
    "them."
)


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
    parts = _Parts(scenario)
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
    parts = _Parts(scenario)
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


class _Parts:
    """The scenario's components by model, and what feeds what."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario
        bundled = [part for part in scenario.components.values() if part.is_bundled]
        self.hands = [part for part in bundled if part.source == "hand"]
        self.objects = [part for part in bundled if part.source == "object"]
        self.couplers = [part for part in bundled if part.source == "virtual_coupler"]
        self.feeding: dict[tuple[str, str], Connection] = {
            (link.target.component, link.target.path): link for link in scenario.connections
        }

    def ties(self) -> list[Tie]:
        """Every coupler with the two bodies that it joins."""
        bodies = {part.name: part for part in (*self.hands, *self.objects)}
        objects = {part.name for part in self.objects}
        found: list[Tie] = []
        for coupler in self.couplers:
            ends = [self._source(coupler, f"position_{end}") for end in "ab"]
            near = [
                end for end in ends if end in objects and bodies[end].station == coupler.station
            ]
            if len(near) != 1 or any(end not in bodies for end in ends):
                raise InputError(
                    f"{coupler.name} does not join the object of its own station to another body: "
                    "the theory knows no such coupler.",
                    self.scenario.locate(("components", coupler.name)),
                )
            other = ends[1] if ends[0] == near[0] else ends[0]
            found.append(Tie(coupler, other, near[0], "ab"[ends.index(near[0])]))
        return found

    def refuse_other_joints(
        self, ties: list[Tie], numbers: dict[str, int], *, distributed: bool
    ) -> None:
        """Refuse parts that are joined, placed or stepped otherwise than the loop's.

        Raises:
            InputError: by name and place.
        """
        parts = {part.name: part for part in (*self.hands, *self.objects, *self.couplers)}
        refuse_double_ties(self.scenario, ties)
        if distributed:
            refuse_other_copies(self.scenario, ties, self.objects)
        else:
            home = self.objects[0].station
            refuse_other_places(self.scenario, self.hands, home, numbers)
        hands = {hand.name: hand for hand in self.hands}
        refuse_other_wires(
            self.scenario,
            parts,
            wires_of(ties, hands, distributed=distributed),
            {f"{name}.force" for name in hands},
        )
        refuse_other_steps(self.scenario, parts.values())

    def _source(self, coupler: ScenarioComponent, path: str) -> str:
        link = self.feeding.get((coupler.name, path))
        return link.source.component if link is not None else ""

    def wall(self) -> dict[str, float]:
        """The wall that every copy of the object is in contact with.

        Raises:
            InputError: the copies have different walls.
        """
        walls = {
            (parameter(body, "wall_stiffness"), parameter(body, "wall_damping"))
            for body in self.objects
        }
        if len(walls) > 1:
            raise InputError(
                "The theory takes one wall for all copies of the object.",
                self.scenario.locate(("components", self.objects[0].name)),
            )
        stiffness, damping = walls.pop()
        return {"k_w": stiffness, "b_w": damping}

    def timing(self, numbers: dict[str, int], notes: list[str], *, distributed: bool) -> Timing:
        """Rates and delays; what the theory leaves out goes into the notes."""
        loop = (*self.hands, *self.objects, *self.couplers)
        periods = {part.period for part in loop}
        late = {int(parameter(part, "computation_delay_ticks")) for part in self.couplers}
        if len(periods) > 1 or len(late) > 1:
            raise InputError(
                "The theory takes one control rate and one computation delay for all hands, "
                "objects and couplers.",
                self.scenario.locate(("components",)),
            )
        if max(late, default=0) and self.wall()["k_w"]:
            raise InputError(
                "An object's wall has no computation delay, and that of chapter 5's loop has the "
                "couplers'.",
                self.scenario.locate(("components", self.objects[0].name)),
            )
        control = periods.pop()
        ways: dict[bool, set[tuple[int, int]]] = {True: set(), False: set()}
        for link in self.scenario.connections:
            if link.via is None:
                self._refuse_late(link)
                continue
            source = self.scenario.components[link.source.component]
            target = self.scenario.components[link.target.component]
            channel = self.scenario.channels[link.via]
            way = channel.direction(source.station, target.station)
            forward = self._is_forward(source, target, numbers, distributed=distributed)
            ways[forward].add((channel.period, self._samples(way, channel.period, notes)))
        rates = {period for way in ways.values() for period, _ in way}
        delays = {forward: {samples for _, samples in way} for forward, way in ways.items()}
        if len(rates) > 1 or any(len(way) > 1 for way in delays.values()):
            raise InputError(
                "The theory takes one network rate and one delay in each direction.",
                self.scenario.locate(("channels",)),
            )
        return Timing(
            control_period=Fraction(control) / self.scenario.base_rate,
            ratio=Fraction(rates.pop(), control) if rates else Fraction(1),
            delay=PathDelay(
                forward=next(iter(delays[True]), 0), backward=next(iter(delays[False]), 0)
            ),
            computation_delay=late.pop() if late else 0,
        )

    def _refuse_late(self, link: Connection) -> None:
        if link.delay.ticks or link.rate is not None:
            raise InputError(
                f"{link} is delayed or sampled inside a station, which chapters 3 to 6 do not "
                "know.",
                self.scenario.locate(("connections",)),
            )

    def _is_forward(
        self,
        source: ScenarioComponent,
        target: ScenarioComponent,
        numbers: dict[str, int],
        *,
        distributed: bool,
    ) -> bool:
        """Centralized: up to the server. Distributed: from the lower user to the higher."""
        if not distributed:
            return target.station == self.objects[0].station
        by_station = {hand.station: numbers[hand.name] for hand in self.hands}
        return by_station[source.station] < by_station[target.station]

    def _samples(self, way: Direction, period: int, notes: list[str]) -> int:
        samples = -(-way.delay.ticks // period)
        if samples * period != way.delay.ticks:
            _note(notes, f"A delay of {way.delay.ticks} ticks is taken as {samples} samples.")
        if way.impairments:
            _note(notes, WITHOUT_CHANCE)
        return samples


def _note(notes: list[str], sentence: str) -> None:
    if sentence not in notes:
        notes.append(sentence)
