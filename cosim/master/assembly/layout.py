"""Which 8-byte cell every value of a run lives in."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from cosim.base.component import Causality, Variable
from cosim.master.assembly.plan import Act, Part, Plan
from cosim.master.assembly.wiring import Held, Signal, Source, Wiring
from cosim.master.components.clocks import age_of
from cosim.master.components.interface import size_of
from cosim.master.kernel.codes import CLOCK_AGE, CLOCK_CELLS, CLOCK_COUNT


@dataclass(slots=True)
class Layout:
    """The first cell of each variable and of what each bundle holds."""

    cells: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
    wanted: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
    """Of what may be turned: the first cell of what it shall be; ``cells`` has what is in force."""
    events: dict[str, int] = field(default_factory=dict[str, int])
    """Of a component in event mode: the cell of the time of its next event; its clocks follow."""
    latched: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
    """Where what is read at events waits until outputs are read: the first cell."""
    before: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
    """What an input was that is set when it changes: the first cell."""
    held: list[int] = field(default_factory=list[int])
    age: list[int] = field(default_factory=list[int])
    sequence: list[int] = field(default_factory=list[int])
    count: int = 0

    def of(self, source: Source) -> int:
        """The cell of one value."""
        if isinstance(source, Signal):
            return self.cells[source.component, source.variable] + source.index
        if isinstance(source, Held):
            return self.held[source.bundle] + source.index
        return (self.age if source.name == "age" else self.sequence)[source.bundle]

    def into(self, target: Signal) -> int:
        """The cell that a connection's value goes to."""
        name = (target.component, target.variable)
        return self.wanted.get(name, self.cells[name]) + target.index

    def owner(self, cell: int) -> tuple[str, str, int]:
        """Component, variable and element behind a variable's cell."""
        known = self.wanted if self.wanted and cell >= min(self.wanted.values()) else self.cells
        if self.latched and cell >= min(self.events.values()):
            known = dict(sorted(self.latched.items(), key=lambda item: item[1]))
        firsts = list(known.values())
        number = bisect_right(firsts, cell) - 1
        component, variable = list(known)[number]
        return component, variable, cell - firsts[number]


def lay_out(
    parts: Mapping[str, Part],
    wiring: Wiring,
    plan: Plan,
    knobs: Mapping[tuple[str, str], Variable],
) -> Layout:
    """Give every value its cell; variables that are set or got together lie side by side.

    ``knobs`` are what may be turned, by component or channel.
    """
    layout = Layout()

    def place(component: str, names: Iterable[str]) -> None:
        variables = parts[component].interface.variables
        new = [name for name in names if (component, name) not in layout.cells]
        for name in sorted(new, key=lambda name: (variables[name].type, name)):
            layout.cells[component, name] = layout.count
            layout.count += size_of(variables[name])

    for action in plan.every:
        if action.act in {Act.SET, Act.GET} and action.unit in parts:
            place(str(action.unit), (str(name) for name in action.names))
    for component, part in sorted(parts.items()):
        interface = part.interface
        place(component, (name for name in interface.variables if interface.lives_in_cells(name)))
    for (owner, name), variable in knobs.items():
        if (owner, name) not in layout.cells:
            layout.cells[owner, name] = layout.count
            layout.count += size_of(variable)
    for bundle in wiring.bundles:
        layout.held.append(layout.count)
        layout.age.append(layout.count + len(bundle.entries))
        layout.sequence.append(layout.count + len(bundle.entries) + 1)
        layout.count += len(bundle.entries) + 2
    for name, variable in knobs.items():
        layout.wanted[name] = layout.count
        layout.count += size_of(variable)
    for component, part in sorted(parts.items()):
        _place_events(layout, component, part)
    return layout


def _place_events(layout: Layout, component: str, part: Part) -> None:
    facts, variables = part.interface.events, part.interface.variables
    if facts is None:
        return
    layout.events[component] = layout.count
    layout.count += 1
    for clock in facts.clocks:
        if not clock.is_triggered_input:
            layout.latched[component, clock.name] = layout.count + CLOCK_COUNT
        if clock.has_age:
            layout.latched[component, age_of(clock.name)] = layout.count + CLOCK_AGE
        layout.count += CLOCK_CELLS
    for variable in variables.values():
        name = variable.name
        if name in facts.clock_names():
            continue
        if variable.causality is Causality.INPUT:
            if name in facts.clocked or not facts.is_event_input(variable):
                continue
            layout.before[component, name] = layout.count
        elif name in facts.clocked:
            layout.latched[component, name] = layout.count
        else:
            continue
        layout.count += size_of(variable)
