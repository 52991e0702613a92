"""Which 8-byte cell every value of a run lives in."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from cosim.master.assembly.plan import Act, Part, Plan
from cosim.master.assembly.wiring import Held, Signal, Source, Wiring
from cosim.master.components.interface import has_cells, size_of


@dataclass(slots=True)
class Layout:
    """The first cell of each variable and of what each bundle holds."""

    cells: dict[tuple[str, str], int] = field(default_factory=dict[tuple[str, str], int])
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

    def owner(self, cell: int) -> tuple[str, str, int]:
        """Component, variable and element behind a variable's cell."""
        firsts = list(self.cells.values())
        number = bisect_right(firsts, cell) - 1
        component, variable = list(self.cells)[number]
        return component, variable, cell - firsts[number]


def lay_out(parts: Mapping[str, Part], wiring: Wiring, plan: Plan) -> Layout:
    """Give every value its cell; variables that are set or got together lie side by side."""
    layout = Layout()

    def place(component: str, names: Iterable[str]) -> None:
        variables = parts[component].interface.variables
        new = [name for name in names if (component, name) not in layout.cells]
        for name in sorted(new, key=lambda name: (variables[name].type, name)):
            layout.cells[component, name] = layout.count
            layout.count += size_of(variables[name])

    for action in plan.every:
        if action.act in {Act.SET, Act.GET} and isinstance(action.unit, str):
            place(action.unit, (str(name) for name in action.names))
    for component, part in sorted(parts.items()):
        variables = part.interface.variables.values()
        place(component, (variable.name for variable in variables if has_cells(variable)))
    for bundle in wiring.bundles:
        layout.held.append(layout.count)
        layout.age.append(layout.count + len(bundle.entries))
        layout.sequence.append(layout.count + len(bundle.entries) + 1)
        layout.count += len(bundle.entries) + 2
    return layout
