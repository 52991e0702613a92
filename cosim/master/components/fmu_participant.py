"""An FMU as a component: its description, its mode, its values and its steps."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim import scenario as scenarios
from cosim.base.component import Causality
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.master.assembly.clock import Clock
from cosim.master.components.clocks import check_grid
from cosim.master.components.parameters import SETTABLE, STARTABLE, resolve_values
from cosim.master.components.participant import Participant, Values
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.loaded.binary import find_binary
from cosim.master.fmu.loaded.substeps import choose_substeps
from cosim.master.fmu.reading import read_description


def read_fmu(
    written: scenarios.ScenarioComponent,
    bundled: Callable[[str, str], Path],
    read: Callable[[Path], FmuDescription],
    clock: Clock,
    problems: Problems,
) -> Participant:
    """Read an FMU; ``bundled`` finds one of ours by model and flavour, ``read`` describes it.

    Raises:
        InputError: it cannot be used.
    """
    own, source = written.is_bundled, written.source
    path = bundled(source, written.flavour) if own else Path(source)
    description = read(path)
    find_binary(description)
    if written.is_strict and description.breaks:
        raise InputError(f"the modelDescription.xml of {path} {_broken(description)}")
    # Structural parameters first: they say how many elements the others have.
    structural = {
        name: value
        for name, value in written.parameters.items()
        if (variable := description.variables.get(name)) is not None
        and variable.causality is Causality.STRUCTURAL_PARAMETER
    }
    parameters = fmu_values(written, description, "parameters", structural, problems)
    if parameters:
        sizes = {name: int(elements[0]) for name, elements in parameters.items()}
        description = read_description(path, sizes)
    description = _in_its_mode(description, written, problems)
    others = {k: v for k, v in written.parameters.items() if k not in structural}
    parameters |= fmu_values(written, description, "parameters", others, problems)
    substeps, note = choose_substeps(description, clock, written.period, written.substeps)
    _check_clocks(description, written, written.period * clock.tick / substeps, problems)
    return Participant(
        name=written.name,
        period=written.period,
        interface=description.interface(written.name, feedthrough=bool(written.feedthrough)),
        parameters=parameters,
        start=fmu_values(written, description, "start", written.start, problems),
        fmu=description,
        substeps=substeps,
        notes=tuple(note for note in (note, *_of_description(description)) if note),
    )


def _in_its_mode(
    description: FmuDescription, written: scenarios.ScenarioComponent, problems: Problems
) -> FmuDescription:
    """With clocks, where event mode is used: where it is asked for, and where there are clocks."""
    wanted = written.event_mode
    if wanted and not description.has_event_mode:
        with problems.at(("components", written.name, "event_mode")):
            raise InputError(
                f"{written.name}: the FMU {description.path.name} has no event mode (hasEventMode, "
                "of FMI 3.0); leave 'event_mode' out"
            )
    return description.in_mode(wanted)


def _check_clocks(
    description: FmuDescription,
    written: scenarios.ScenarioComponent,
    step: Fraction,
    problems: Problems,
) -> None:
    if description.events is None:
        return
    for clock in description.events.clocks:
        with problems.at(("components", written.name, "rate")):
            check_grid(clock, step)
    for name in sorted(written.start.keys() & description.events.clock_names()):
        with problems.at(("components", written.name, "start", name)):
            raise InputError(f"{written.name}.{name} is a clock's: it has no value to start with")


def _of_description(description: FmuDescription) -> list[str]:
    notes = [f"its modelDescription.xml {_broken(description)}"] if description.breaks else []
    outputs = [n for n, why in description.skipped.items() if why == Causality.OUTPUT]
    if outputs:
        notes.append(
            f"{', '.join(outputs)} of the FMU {description.path.name} belong to clocks, which "
            "tick in event mode alone: they are skipped"
            if description.events is None
            else f"{', '.join(outputs)} of the FMU {description.path.name} are texts that belong "
            "to clocks: they are skipped"
        )
    return notes


def _broken(description: FmuDescription) -> str:
    first, *others = description.breaks
    return f"is not valid: {first}" + (f" (and {len(others)} more)" if others else "")


def fmu_values(
    written: scenarios.ScenarioComponent,
    description: FmuDescription,
    section: str,
    values: Mapping[str, Any],
    problems: Problems,
) -> Values:
    """The values of a section; what does not fit is reported and left out."""
    allowed = SETTABLE if section == "parameters" else STARTABLE
    resolved: Values = {}
    for name, value in values.items():
        with problems.at(("components", written.name, section, name)):
            found = resolve_values(
                written.name, description.variables, name, value, allowed, units=description.units
            )
            if own := found.keys() & set(description.calculated):
                raise InputError(
                    f"{written.name}.{min(own)} has no start: the FMU calculates its first value "
                    "(initial)"
                )
            resolved |= found
    return resolved
