"""The hands, objects and virtual couplers of a single-axis scenario, and what feeds what."""

from __future__ import annotations

from fractions import Fraction

from cosim.analysis.chance.delays import HARMLESS
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
from cosim.theory.models.timing import PathDelay, Timing

WITHOUT_CHANCE = (
    "Loss, jitter and reordering of the channels are left out here; theory radius and theory loss "
    "take them, and theory design does."
)


class Parts:
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
        if way.impairments.keys() - HARMLESS:
            _note(notes, WITHOUT_CHANCE)
        return samples


def _note(notes: list[str], sentence: str) -> None:
    if sentence not in notes:
        notes.append(sentence)
