"""Operations that belong to no program, but to the events of an FMU."""

from __future__ import annotations

from cosim.master.assembly.plan import Act, Action, Plan
from cosim.master.kernel.events import EventStructures
from cosim.master.kernel.operations import Operations
from cosim.master.kernel.turning import Turning


def write_events(
    structures: EventStructures, step: Action, plan: Plan, turning: Turning, operations: Operations
) -> int:
    """The address of what an FMU's instance points to; ``step`` is the action that steps it."""
    unit = str(step.unit)
    driven = {
        str(name)
        for action in plan.every
        if action.act is Act.SET and action.unit == unit
        for name in action.names
        if (unit, name) not in turning.knobs
    }
    sets: dict[str, int] = {}
    gets: dict[str, int] = {}
    for name in structures.sets(driven):
        for written in operations.accesses.of(unit, [name], is_set=True):
            sets[name] = operations.add(written, step)
    for name in structures.gets():
        for written in operations.accesses.of(unit, [name], is_set=False):
            written.operation.cells = structures.place_of(name)
            gets[name] = operations.add(written, step)
    return structures.begin(sets, gets)
