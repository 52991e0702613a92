"""The order in which outputs are evaluated inside a tick, and the refusal of algebraic loops.

A unit is a component or a bundle; its atoms are the values that it provides: a component's output
variables, the elements that a bundle holds. An atom needs other atoms of the same tick where an
output depends directly on an input (declared, and the component says ``feedthrough: true``), or
where a packet arrives in the tick in which it was sampled. Atoms are gathered in as few stages a
unit as that allows: each stage is one set and one get.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from cosim.base.errors import InputError
from cosim.master.assembly.interface import Interface
from cosim.master.assembly.wiring import Held, Signal, Wiring

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


def order(graph: Graph) -> list[Stage] | list[Atom]:
    """The stages in order, or the atoms of a loop where there is one.

    Of the units that could go on, one that can finish comes first; then one that must be split
    because what is left of it depends on what is ready of it; then the one with most to do. Names
    break ties, so the order of a scenario's components changes nothing.
    """
    behind = _everything_behind(graph)
    if behind is None:
        return _find_loop(graph)
    bit = {atom: 1 << number for number, atom in enumerate(graph.needs)}
    waiting: dict[Unit, set[Atom]] = {}
    for atom in graph.needs:
        waiting.setdefault(atom[0], set()).add(atom)

    stages: list[Stage] = []
    done = 0
    while waiting:
        best: tuple[int, int, str] | None = None
        chosen: tuple[Unit, set[Atom]] = ("", set())
        for unit, atoms in waiting.items():
            ready = {atom for atom in atoms if behind[atom] & ~done == 0}
            if not ready:
                continue
            own = sum(bit[atom] for atom in ready)
            left = atoms - ready
            must_split = any(behind[atom] & own for atom in left)
            rank = (0 if not left else 1 if must_split else 2, -len(ready), str(unit))
            if best is None or rank < best:
                best, chosen = rank, (unit, ready)
        unit, ready = chosen
        stages.append(Stage(unit, tuple(sorted((name for _, name in ready), key=str))))
        done |= sum(bit[atom] for atom in ready)
        waiting[unit] -= ready
        if not waiting[unit]:
            del waiting[unit]
    return stages


def _everything_behind(graph: Graph) -> dict[Atom, int] | None:
    """For each atom, the set (as bits) of all that it needs in the end; ``None``: a loop."""
    bit = {atom: 1 << number for number, atom in enumerate(graph.needs)}
    missing = {atom: len(needed) for atom, needed in graph.needs.items()}
    dependents: dict[Atom, list[Atom]] = {}
    for atom, needed in graph.needs.items():
        for other in needed:
            dependents.setdefault(other, []).append(atom)
    behind = dict.fromkeys(graph.needs, 0)
    ready = [atom for atom, count in missing.items() if count == 0]
    for atom in ready:  # grows while it is read
        for dependent in dependents.get(atom, ()):
            behind[dependent] |= behind[atom] | bit[atom]
            missing[dependent] -= 1
            if missing[dependent] == 0:
                ready.append(dependent)
    return behind if len(ready) == len(graph.needs) else None


def _find_loop(graph: Graph) -> list[Atom]:
    stuck = dict(graph.needs)
    while free := [a for a, needed in stuck.items() if not any(b in stuck for b in needed)]:
        for atom in free:
            del stuck[atom]
    atom = min(stuck, key=str)
    path: list[Atom] = []
    while atom not in path:
        path.append(atom)
        atom = min((other for other in stuck[atom] if other in stuck), key=str)
    loop = path[path.index(atom) :][::-1]
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
