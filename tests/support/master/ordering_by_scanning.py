"""The order of evaluation by its definition: every unit is looked at anew before each stage.

Quadratic, and plain enough to be read as what ``cosim.master.assembly.ordering`` has to do.
"""

from __future__ import annotations

from cosim.master.assembly.ordering import Atom, Graph, Stage, Unit


def order_by_scanning(graph: Graph) -> list[Stage] | list[Atom]:
    """The stages in order, or the atoms of a loop where there is one."""
    behind = everything_behind(graph)
    if behind is None:
        return a_loop(graph)
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


def everything_behind(graph: Graph) -> dict[Atom, int] | None:
    """For each atom, the set (as bits) of all that it needs in the end; ``None``: a loop."""
    bit = {atom: 1 << number for number, atom in enumerate(graph.needs)}
    behind = dict.fromkeys(graph.needs, 0)
    for _ in range(len(graph.needs) + 1):
        before = dict(behind)
        for atom, needed in graph.needs.items():
            for other in needed:
                behind[atom] |= behind[other] | bit[other]
        if behind == before:
            break
    return None if any(behind[atom] & bit[atom] for atom in behind) else behind


def a_loop(graph: Graph) -> list[Atom]:
    """The loop met by going back from the first atom (by name) that waits for one."""
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
