"""Taking a snapshot of a run between two ticks, and putting it back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from cosim.base.component import Component
from cosim.base.errors import CohapticError, InputError, RunError
from cosim.base.resumable import Resumable, not_plain
from cosim.master.assembly.assemble import Assembly
from cosim.master.components.python_component import sentences
from cosim.master.fmu.instance import Fmu
from cosim.master.kernel.program import Program
from cosim.master.run.diagnosis import moment
from cosim.master.run.fingerprint import components_of, difference, plan_digest
from cosim.master.run.snapshot import Snapshot
from cosim.scenario import Kind


def without_state(assembly: Assembly) -> tuple[str, ...]:
    """The FMUs that do not give their state away: a run with them is repeated from tick 0."""
    return tuple(
        name
        for name, each in assembly.participants.items()
        if each.fmu is not None and not each.fmu.saves_state
    )


def refuse_unless_resumable(assembly: Assembly) -> None:
    """Whether a snapshot can be taken at all.

    Raises:
        InputError: a device, or a Python component without ``save`` and ``load``.
    """
    for name, each in assembly.participants.items():
        if assembly.scenario.components[name].kind is Kind.DEVICE:
            raise InputError(
                f"{name} is a device, and what it is doing cannot be saved or put back; take the "
                "snapshot of a run with a simulated one."
            )
        if each.component is not None and not isinstance(each.component, Resumable):
            raise InputError(
                f"{name} ({type(each.component).__name__}) has no save() and load(): give it a "
                "save() that returns all that it remembers as plain values (numbers, texts, lists, "
                "dictionaries), and a load(values) that takes them back."
            )


def take(
    assembly: Assembly,
    program: Program,
    fmus: Mapping[str, Fmu],
    components: Mapping[str, Component],
) -> Snapshot:
    """The state between two ticks.

    Raises:
        InputError: a component cannot be saved.
        RunError: one failed while it was.
    """
    refuse_unless_resumable(assembly)
    kernel = program.kernel
    arrays: dict[str, Any] = {"cells": program.cells.copy(), **program.texts.save()}
    if not without_state(assembly):
        for name, fmu in fmus.items():
            content = fmu.states.save(f" at {moment(program)}")
            arrays[f"fmu.{name}"] = np.frombuffer(content, dtype=np.uint8)
    bundles: list[Any] = []
    for number in range(len(assembly.wiring.bundles)):
        values, tables = program.packets.save(number)
        bundles.append(values)
        arrays |= {f"bundle.{number}.{key}": table for key, table in tables.items()}
    return Snapshot(
        tick=int(kernel.tick),
        plan=plan_digest(assembly),
        components=components_of(assembly),
        values={
            "phase": int(kernel.phase),
            "warnings": program.warnings(),
            "bundles": bundles,
            "python": {name: saved(name, each) for name, each in components.items()},
        },
        arrays=arrays,
    )


def check(assembly: Assembly, snapshot: Snapshot) -> None:
    """Whether a snapshot is one of this run.

    Raises:
        InputError: it was taken of another plan, with another FMU or with other values.
    """
    refuse_unless_resumable(assembly)
    other = difference(snapshot.components, components_of(assembly))
    if other is None and snapshot.plan != plan_digest(assembly):
        other = (
            "it was taken of another plan: rates, connections, channels, seed, and what is recorded"
            " must be the same; only the duration may differ."
        )
    if other is not None:
        raise InputError(f"The snapshot of tick {snapshot.tick} cannot be used: {other}")


def put_back(
    snapshot: Snapshot,
    program: Program,
    fmus: Mapping[str, Fmu],
    components: Mapping[str, Component],
) -> None:
    """Make everything as it was; initialisation is over, and the snapshot was checked.

    Raises:
        RunError: a component does not take its state back.
    """
    values, arrays = snapshot.values, snapshot.arrays
    kernel = program.kernel
    try:
        for name, fmu in fmus.items():
            when = f" at {moment(program)}"
            fmu.states.load(arrays[f"fmu.{name}"].tobytes(), when)
        program.cells[:] = arrays["cells"]
        program.texts.load(arrays)
        program.channels.take_back()
        for number, saved in enumerate(values["bundles"]):
            prefix = f"bundle.{number}."
            tables = {
                key.removeprefix(prefix): table
                for key, table in arrays.items()
                if key.startswith(prefix)
            }
            program.packets.load(number, saved, tables)
        program.set_warnings(values["warnings"])
        kernel.phase, kernel.tick = int(values["phase"]) % int(kernel.hyperperiod), snapshot.tick
        program.turning.go_on(kernel, snapshot.tick)
        load_components(components, values["python"])
    except CohapticError:
        raise
    except (KeyError, TypeError, ValueError) as error:
        raise RunError(
            f"The snapshot of tick {snapshot.tick} cannot be put back: {error}"
        ) from error


def load_components(components: Mapping[str, Component], saved: Mapping[str, Any]) -> None:
    """Give every component that can take it what it saved.

    Raises:
        RunError: one does not take it back.
    """
    for name, component in components.items():
        if isinstance(component, Resumable):
            with sentences(name, "in load"):
                component.load(saved[name])


def same_state(snapshot: Snapshot, program: Program) -> bool:
    """Whether a run that was repeated up to a snapshot has the values that it had then."""
    return program.texts.are_those_of(snapshot.arrays["cells"], snapshot.arrays)


def saved(name: str, component: Component) -> Any:
    """What a component remembers.

    Raises:
        RunError: it failed, or returned what is not plain.
    """
    assert isinstance(component, Resumable)
    with sentences(name, "in save"):
        values = component.save()
    bad = not_plain(values)
    if bad is not None:
        raise RunError(
            f"{name}: save() returned {bad}; only plain values can be saved: None, true and false, "
            "numbers, texts, lists, and dictionaries with texts as keys."
        )
    return values
