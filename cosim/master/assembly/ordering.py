"""The order in which outputs are evaluated inside a tick, and the refusal of algebraic loops.

A unit is a component or a bundle; its atoms are the values that it provides: a component's output
variables, the elements that a bundle holds. An atom needs other atoms of the same tick where an
output depends directly on an input (declared, and the component says ``feedthrough: true``), or
where a packet arrives in the tick in which it was sampled. Atoms are gathered in as few stages a
unit as that allows: each stage is one set and one get.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

from cosim.base.errors import InputError
from cosim.master.assembly.wiring import Held, Signal, Wiring
from cosim.master.components.interface import Interface

Unit = str | int
"""A component's name, or a bundle's number."""

Atom = tuple[Unit, str | int]
"""A component's output variable, or an element of what a bundle holds."""


@dataclass(frozen=True, slots=True)
class Stage:
    """Atoms of one unit that are evaluated together."""

    unit: Unit
    atoms: tuple[str | int, ...]


@dataclass(frozen=True, slots=True)
class Graph:
    """What each atom needs from the same tick; ``through`` names the input on the way."""

    needs: Mapping[Atom, Mapping[Atom, str | None]]


def build_graph(
    interfaces: Mapping[str, Interface],
    wiring: Wiring,
    outputs: Mapping[str, Iterable[str]],
    *,
    at_start: bool = False,
    initialising: bool = False,
) -> Graph:
    """The dependencies among the atoms of a tick.

    ``outputs`` are the output variables that anybody reads. ``at_start`` is tick 0, where a bundle
    also holds the source's value of the same tick; ``initialising`` counts what outputs depend on
    in initialisation mode as well.
    """
    into: dict[tuple[str, str], list[Atom]] = {}
    for wire in wiring.wires:
        source = wire.source
        if isinstance(source, Signal):
            atom: Atom = (source.component, source.variable)
        elif isinstance(source, Held):
            atom = (source.bundle, source.index)
        else:
            continue
        into.setdefault((wire.target.component, wire.target.variable), []).append(atom)

    needs: dict[Atom, dict[Atom, str | None]] = {}
    for component, names in outputs.items():
        for output in names:
            inputs = interfaces[component].outputs_depend_on(output, initially=initialising)
            needs[component, output] = {
                atom: name for name in inputs for atom in into.get((component, name), ())
            }
    for number, bundle in enumerate(wiring.bundles):
        for index, entry in enumerate(bundle.entries):
            same_tick = bundle.can_be_immediate or (at_start and entry.target is None)
            if same_tick and isinstance(entry.source, Signal):
                needs[number, index] = {(entry.source.component, entry.source.variable): None}
            elif same_tick:
                needs[number, index] = {}
    known = set(needs)
    return Graph({a: {b: via for b, via in bs.items() if b in known} for a, bs in needs.items()})


_Rank = tuple[int, int, str, int, Unit]
"""How urgent a unit is, most ready atoms first, its name, and its number and itself."""


def order(graph: Graph) -> list[Stage] | list[Atom]:
    """The stages in order, or the atoms of a loop where there is one.

    Of the units that could go on, one that can finish comes first; then one that must be split
    because what is left of it depends on what is ready of it; then the one with most to do. Names
    break ties, so the order of a scenario's components changes nothing.

    A unit's rank changes only when more of it becomes ready, so the units wait in a heap, and an
    entry that a later one has replaced is passed over.
    """
    dependents = _dependents(graph)
    inside = _needs_inside_units(graph, dependents)
    missing = {atom: len(needed) for atom, needed in graph.needs.items()}
    waiting: dict[Unit, set[Atom]] = {}
    ready: dict[Unit, set[Atom]] = {}
    for atom in graph.needs:
        waiting.setdefault(atom[0], set()).add(atom)
        if not missing[atom]:
            ready.setdefault(atom[0], set()).add(atom)
    numbers = {unit: number for number, unit in enumerate(waiting)}
    heap: list[_Rank] = []
    newest: dict[Unit, _Rank] = {}

    def push(unit: Unit) -> None:
        left = waiting[unit] - ready[unit]
        must_split = any(not ready[unit].isdisjoint(inside.get(atom, ())) for atom in left)
        urgency = 0 if not left else 1 if must_split else 2
        newest[unit] = (urgency, -len(ready[unit]), str(unit), numbers[unit], unit)
        heappush(heap, newest[unit])

    for unit in ready:
        push(unit)
    stages: list[Stage] = []
    while heap:
        rank = heappop(heap)
        unit = rank[-1]
        if newest[unit] is not rank:
            continue
        atoms = ready.pop(unit)
        stages.append(Stage(unit, tuple(sorted((name for _, name in atoms), key=str))))
        waiting[unit] -= atoms
        grown: dict[Unit, None] = {}
        for atom in atoms:
            for dependent in dependents.get(atom, ()):
                missing[dependent] -= 1
                if not missing[dependent]:
                    ready.setdefault(dependent[0], set()).add(dependent)
                    grown[dependent[0]] = None
        for other in grown:
            push(other)
    if any(missing.values()):
        return _find_loop(graph, dependents)
    return stages


def _dependents(graph: Graph) -> dict[Atom, list[Atom]]:
    dependents: dict[Atom, list[Atom]] = {}
    for atom, needed in graph.needs.items():
        for other in needed:
            dependents.setdefault(other, []).append(atom)
    return dependents


def _needs_inside_units(
    graph: Graph, dependents: Mapping[Atom, Sequence[Atom]]
) -> dict[Atom, tuple[Atom, ...]]:
    """For each atom, those of its own unit that it needs in the end, by whatever way.

    Such a way leads out of the unit and back, so only units on a circle of units are looked at.
    What an atom needs is a set of bits, and dropped as soon as everything behind it is done.
    """
    circle = _units_on_circles(graph)
    members: dict[Unit, list[Atom]] = {}
    missing: dict[Atom, int] = {}
    for atom, needed in graph.needs.items():
        if atom[0] in circle:
            members.setdefault(atom[0], []).append(atom)
            missing[atom] = sum(other[0] in circle for other in needed)
    bit: dict[Atom, int] = {}
    for atoms in members.values():
        if len(atoms) > 1:
            bit |= {atom: 1 << (len(bit) + number) for number, atom in enumerate(atoms)}
    behind = dict.fromkeys(missing, 0)
    inside: dict[Atom, tuple[Atom, ...]] = {}
    ready = [atom for atom, count in missing.items() if not count]
    for atom in ready:  # grows while it is read
        reached = behind.pop(atom)
        if reached and atom in bit:
            inside[atom] = tuple(other for other in members[atom[0]] if reached & bit[other])
        reached |= bit.get(atom, 0)
        for dependent in dependents.get(atom, ()):
            if dependent in missing:
                behind[dependent] |= reached
                missing[dependent] -= 1
                if not missing[dependent]:
                    ready.append(dependent)
    return inside


def _units_on_circles(graph: Graph) -> set[Unit]:
    """Every unit that needs itself through others, and perhaps some between two such circles."""
    needs: dict[Unit, set[Unit]] = {}
    for atom, needed in graph.needs.items():
        needs.setdefault(atom[0], set()).update(other[0] for other in needed)
    left = set(needs)
    for forward in (True, False):
        after: dict[Unit, list[Unit]] = {unit: [] for unit in left}
        before = dict.fromkeys(left, 0)
        for unit in left:
            for other in needs[unit] & left:
                first, second = (other, unit) if forward else (unit, other)
                after[first].append(second)
                before[second] += 1
        ends = [unit for unit, count in before.items() if not count]
        for unit in ends:  # grows while it is read
            left.discard(unit)
            for other in after[unit]:
                before[other] -= 1
                if not before[other]:
                    ends.append(other)
    return left


def _find_loop(graph: Graph, dependents: Mapping[Atom, Sequence[Atom]]) -> list[Atom]:
    missing = {atom: len(needed) for atom, needed in graph.needs.items()}
    free = [atom for atom, count in missing.items() if not count]
    for atom in free:  # grows while it is read
        del missing[atom]
        for dependent in dependents.get(atom, ()):
            missing[dependent] -= 1
            if not missing[dependent]:
                free.append(dependent)
    atom = min(missing, key=str)
    path: dict[Atom, None] = {}
    while atom not in path:
        path[atom] = None
        atom = min((other for other in graph.needs[atom] if other in missing), key=str)
    walked = list(path)
    loop = walked[walked.index(atom) :][::-1]
    first = loop.index(min(loop, key=str))
    return loop[first:] + loop[:first]


def refuse_loop(loop: list[Atom], graph: Graph, wiring: Wiring, *, at_start: bool) -> InputError:
    """The sentence that spells an algebraic loop out and says how to break it.

    ``loop`` lists atoms so that each needs the one before it, and the first the last.
    """
    parts: list[str] = []
    advice = ""
    for position, (unit, name) in enumerate(loop):
        if isinstance(unit, int):
            continue
        before = loop[position - 1]
        entry = graph.needs[unit, name].get(before)
        connection = _connection(wiring, unit, entry)
        if not advice or (at_start and isinstance(before[0], int)):
            advice = connection
        parts.append(f"{unit}.{entry} -> {unit}.{name}")
    first = parts[0].split(" -> ")[0]
    cycle = " -> ".join([*parts, first])
    if at_start:
        return InputError(
            f"the first values depend on each other in a circle: {cycle}; give the connection "
            f"'{advice}' the option 'initial: start'"
        )
    return InputError(
        f"algebraic loop, each value needs the next in the same tick: {cycle}; put a delay of one "
        f"tick on the connection '{advice}'"
    )


def _connection(wiring: Wiring, component: str, variable: str | None) -> str:
    for target, connection in wiring.connection_of.items():
        if (target.component, target.variable) == (component, variable):
            return connection
    return ""
