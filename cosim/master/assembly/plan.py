"""The plan of a run: what is done in a tick, in which order, and which rows are recorded.

At tick k, in this order: packets arrive and devices read; outputs that depend on inputs are
evaluated in dependency order, zero-delay packets among them; devices write; samplers send; the
remaining inputs are set; rows are recorded; components step over their period.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Causality, Played
from cosim.master.assembly.ordering import Atom, Graph, Stage, build_graph, order, refuse_loop
from cosim.master.assembly.wiring import Wiring
from cosim.master.components.interface import Interface


class Act(Enum):
    """One kind of thing that is done in a tick."""

    DELIVER = auto()
    READ = auto()
    SET = auto()
    GET = auto()
    HOLD = auto()
    SAMPLE = auto()
    TUNE = auto()
    WRITE = auto()
    SEND = auto()
    RECORD = auto()
    STEP = auto()


@dataclass(frozen=True, slots=True)
class Action:
    """Something done every ``period`` ticks.

    ``unit`` is a component, the number of a bundle or record group, or a channel that is turned;
    ``names`` are the inputs of a SET (and what is turned), the outputs of a GET, the held elements
    of a HOLD or SAMPLE, the dials of a TUNE.
    """

    act: Act
    unit: str | int
    period: int
    names: tuple[str | int, ...] = ()


@dataclass(frozen=True, slots=True)
class Part:
    """A component as the plan sees it."""

    interface: Interface
    period: int
    is_fmu: bool
    methods: frozenset[str] = frozenset()
    """Of a Python component or device: which of read, evaluate, write and step it has."""
    played: Played | None = None
    """Rows over time that are shown at its outputs."""

    def overrides(self, method: str) -> bool:
        """Whether a Python component or device does anything in ``method``."""
        return method in self.methods


@dataclass(slots=True)
class Plan:
    """Three programs: initialisation mode, tick 0, and every tick."""

    initial: list[Action] = field(default_factory=list[Action])
    first: list[Action] = field(default_factory=list[Action])
    every: list[Action] = field(default_factory=list[Action])

    def without_recording(self) -> Plan:
        """The same plan for a run that nobody records."""
        first, every = (
            [action for action in actions if action.act is not Act.RECORD]
            for actions in (self.first, self.every)
        )
        return Plan(self.initial, first, every)


@dataclass(frozen=True, slots=True)
class Planner:
    """Everything that the order of actions follows from."""

    parts: Mapping[str, Part]
    wiring: Wiring
    outputs: Mapping[str, tuple[str, ...]]
    """Output variables that somebody reads, by component."""
    locals: Mapping[str, tuple[str, ...]]
    """Further variables that are only recorded."""
    record_periods: tuple[int, ...]
    dials: Mapping[str, Mapping[str, int]] = field(default_factory=dict[str, Mapping[str, int]])
    """What may be turned of a channel, and after how many ticks it can come into force."""
    connected: dict[str, set[str]] = field(init=False, default_factory=dict[str, set[str]])
    """The input variables that something drives, by component."""

    def __post_init__(self) -> None:
        for wire in self.wiring.wires:
            self.connected.setdefault(wire.target.component, set()).add(wire.target.variable)
        for name, part in self.parts.items():
            if part.interface.knobs:
                self.connected.setdefault(name, set()).update(part.interface.knobs)

    def plan(self) -> Plan:
        """Order everything.

        Raises:
            InputError: an algebraic loop.
        """
        interfaces = {name: part.interface for name, part in self.parts.items()}

        def graph(*, at_start: bool = False, initialising: bool = False) -> Graph:
            return build_graph(
                interfaces,
                self.wiring,
                self.outputs,
                at_start=at_start,
                initialising=initialising,
            )

        every = self._stages(graph(), at_start=False)
        first = self._stages(graph(at_start=True), at_start=True)
        # Where priming an output would close a circle, initialisation keeps to tick 0's order.
        initial = _stages_or_none(graph(at_start=True, initialising=True)) or first
        return Plan(
            initial=[
                *self._evaluation(initial, at_start=True, initially=True),
                *self._remaining(initial, initially=True),
                *self._wanted(),
            ],
            first=self._tick(first, at_start=True),
            every=self._tick(every, at_start=False),
        )

    def _stages(self, graph: Graph, *, at_start: bool) -> list[Stage]:
        found = order(graph)
        stages = [item for item in found if isinstance(item, Stage)]
        if len(stages) < len(found):
            loop: list[Atom] = [item for item in found if not isinstance(item, Stage)]
            raise refuse_loop(loop, graph, self.wiring, at_start=at_start)
        return stages

    def _tick(self, stages: list[Stage], *, at_start: bool) -> list[Action]:
        actions = [
            Action(Act.TUNE, channel, period, (dial,))
            for channel, dials in sorted(self.dials.items())
            for dial, period in sorted(dials.items())
        ]
        actions += [Action(Act.DELIVER, number, 1) for number in range(len(self.wiring.bundles))]
        actions += [
            Action(Act.READ, name, part.period)
            for name, part in sorted(self.parts.items())
            if part.overrides("read")
        ]
        actions += self._evaluation(stages, at_start=at_start)
        remaining = self._remaining(stages)
        writers = {name for name, part in self.parts.items() if part.overrides("write")}
        actions += [action for action in remaining if action.unit in writers]
        actions += [Action(Act.WRITE, name, self.parts[name].period) for name in sorted(writers)]
        actions += [
            Action(Act.SEND, number, bundle.period)
            for number, bundle in enumerate(self.wiring.bundles)
        ]
        actions += [action for action in remaining if action.unit not in writers]
        actions += [
            Action(Act.GET, name, self.parts[name].period, names)
            for name, names in sorted(self.locals.items())
        ]
        actions += self._wanted()
        actions += [
            Action(Act.RECORD, number, period) for number, period in enumerate(self.record_periods)
        ]
        actions += [
            Action(Act.STEP, name, part.period) for name, part in sorted(self.parts.items())
        ]
        return actions

    def _evaluation(
        self, stages: Iterable[Stage], *, at_start: bool, initially: bool = False
    ) -> list[Action]:
        """The stages, each with the inputs that it needs and that no stage before it has set."""
        actions: list[Action] = []
        done: dict[str, set[str]] = {}
        for stage in stages:
            if isinstance(stage.unit, int):
                actions += self._bundle_stage(stage.unit, stage.atoms, at_start=at_start)
                continue
            part = self.parts[stage.unit]
            inputs = self._inputs(stage, part, initially) - done.get(stage.unit, set())
            if inputs:
                done.setdefault(stage.unit, set()).update(inputs)
                actions.append(Action(Act.SET, stage.unit, part.period, tuple(sorted(inputs))))
            actions.append(Action(Act.GET, stage.unit, part.period, stage.atoms))
        return actions

    def _bundle_stage(
        self, number: int, atoms: tuple[str | int, ...], *, at_start: bool
    ) -> list[Action]:
        bundle = self.wiring.bundles[number]
        actions: list[Action] = []
        held = tuple(
            index
            for index in atoms
            if isinstance(index, int) and bundle.entries[index].target is None
        )
        if at_start and held:
            actions.append(Action(Act.HOLD, number, bundle.period, held))
        if bundle.can_be_immediate:
            actions.append(Action(Act.SAMPLE, number, bundle.period, atoms))
        return actions

    def _inputs(self, stage: Stage, part: Part, initially: bool) -> set[str]:
        connected = self.connected.get(str(stage.unit), set[str]())
        needed = {
            name for output in stage.atoms for name in part.interface.outputs_depend_on(str(output))
        }
        return needed & connected

    def _remaining(self, stages: Iterable[Stage], *, initially: bool = False) -> list[Action]:
        """Inputs that no output depends on directly, set before the step."""
        done: dict[str, set[str]] = {}
        for stage in stages:
            if isinstance(stage.unit, str):
                part = self.parts[stage.unit]
                done.setdefault(stage.unit, set()).update(self._inputs(stage, part, initially))
        actions: list[Action] = []
        for name, part in sorted(self.parts.items()):
            left = self.connected.get(name, set[str]()) - done.get(name, set())
            if left:
                actions.append(Action(Act.SET, name, part.period, tuple(sorted(left))))
        return actions

    def _wanted(self) -> list[Action]:
        """What components put out for channels, which go by it from the next tick on."""
        return [
            Action(Act.SET, channel, 1, tuple(sorted(self.connected[channel])))
            for channel in sorted(self.dials)
            if channel in self.connected
        ]

    def lagging(self) -> list[str]:
        """Connections into components whose outputs answer one of their steps late.

        Their outputs are read after a step and their inputs set before the next, because they do
        not say ``feedthrough: true``.
        """
        return sorted(
            {
                connection
                for target, connection in self.wiring.connection_of.items()
                if (part := self.parts.get(target.component)) is not None
                and part.is_fmu
                and not part.interface.feedthrough
                and any(
                    variable.causality is Causality.OUTPUT
                    for variable in part.interface.variables.values()
                )
            }
        )


def _stages_or_none(graph: Graph) -> list[Stage] | None:
    found = order(graph)
    stages = [item for item in found if isinstance(item, Stage)]
    return stages if len(stages) == len(found) else None


def due_together(
    periods: Iterable[int], hyperperiod: int
) -> tuple[list[frozenset[int]], NDArray[np.int32]]:
    """The distinct sets of periods that are due in one tick, and which one each tick has."""
    distinct = sorted(set(periods))
    ticks = np.arange(hyperperiod)
    due = np.stack([ticks % period == 0 for period in distinct], axis=1)
    sets, pattern = np.unique(due, axis=0, return_inverse=True)
    members = [
        frozenset(period for period, is_due in zip(distinct, row, strict=True) if is_due)
        for row in sets.tolist()
    ]
    return members, pattern.reshape(-1).astype(np.int32)
