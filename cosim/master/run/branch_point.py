"""Where runs of one simulation part: a state in this process, gone back to as often as wanted.

A snapshot is bytes and can be carried elsewhere; an origin holds the FMUs' own state objects, so
that going back costs a tenth. What channels do from then on may differ from run to run, since what
is drawn for a packet follows from its number.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Component
from cosim.base.errors import InputError, RunError
from cosim.master.assembly.assemble import Assembly
from cosim.master.fmu.instance import Fmu
from cosim.master.kernel.program import Program
from cosim.master.run.checkpoint import (
    load_components,
    refuse_unless_resumable,
    saved,
    without_state,
)
from cosim.master.run.diagnosis import moment
from cosim.master.run.fingerprint import components_of, difference


@dataclass(frozen=True, slots=True, eq=False)
class BranchPoint:
    """A state between two ticks; the FMUs keep theirs themselves."""

    assembly: Assembly
    tick: int
    phase: int
    cells: NDArray[np.int64]
    texts: Mapping[str, NDArray[Any]]
    bundles: tuple[tuple[dict[str, Any], dict[str, NDArray[np.int64]]], ...]
    python: Mapping[str, Any]
    warnings: Mapping[str, int]


def mark(
    assembly: Assembly,
    program: Program,
    fmus: Mapping[str, Fmu],
    components: Mapping[str, Component],
) -> BranchPoint:
    """The state now.

    Raises:
        InputError: a device, a component without ``save`` and ``load``, or an FMU that does not
            give its state away.
        RunError: a component failed.
    """
    refuse_unless_resumable(assembly)
    stateless = without_state(assembly)
    if stateless:
        raise InputError(
            f"The FMU of {stateless[0]} does not give its state away, so that runs cannot begin in "
            "the middle: let them begin at 0."
        )
    if assembly.knobs.all:
        name = ".".join(next(iter(assembly.knobs.all)))
        raise InputError(
            f"{name} is turned while it runs, so that runs cannot begin in the middle."
        )
    for fmu in fmus.values():
        fmu.states.keep(f" at {moment(program)}")
    kernel = program.kernel
    return BranchPoint(
        assembly=assembly,
        tick=int(kernel.tick),
        phase=int(kernel.phase),
        cells=program.cells.copy(),
        texts=program.texts.save(),
        bundles=tuple(program.packets.save(n) for n in range(len(assembly.wiring.bundles))),
        python={name: saved(name, component) for name, component in components.items()},
        warnings=program.warnings(),
    )


def check_branch(origin: BranchPoint, assembly: Assembly) -> None:
    """Whether a run of an assembly may begin where another one was.

    Raises:
        InputError: a component has other values, which count from tick 0 on.
    """
    before, after = components_of(origin.assembly), components_of(assembly)
    other = difference(before, after)
    if other is not None:
        name = next(name for name in before if before[name] != after[name])
        raise InputError(
            f"Runs that begin at tick {origin.tick} of one and the same run differ in their seed "
            f"and channels only; {name} has other parameters or start values, which count from "
            "tick 0."
        )


def go_back(
    origin: BranchPoint,
    assembly: Assembly,
    program: Program,
    fmus: Mapping[str, Fmu],
    components: Mapping[str, Component],
) -> None:
    """Be at the origin, with the packets of ``assembly`` from then on.

    Raises:
        RunError: a component does not take its state back, or more packets are under way than a
            channel of the assembly can hold.
    """
    program.rewind(assembly.wiring)
    for fmu in fmus.values():
        fmu.states.go_back(f" at {moment(program)}")
    for number, (values, tables) in enumerate(origin.bundles):
        try:
            program.packets.branch(number, values, tables)
        except ValueError as error:
            raise RunError(f"{assembly.wiring.bundles[number].name}: {error}") from error
    program.refresh()
    program.set_warnings(origin.warnings)
    program.kernel.tick, program.kernel.phase = origin.tick, origin.phase
    program.cells[:] = origin.cells
    program.texts.load(origin.texts)
    load_components(components, origin.python)
