"""The components of a scenario, read and checked one by one."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, cast

from cosim import scenario as scenarios
from cosim.base.changed import changed
from cosim.base.component import Causality, Component
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.master.assembly.clock import Clock
from cosim.master.components.fmu_participant import fmu_values, read_fmu
from cosim.master.components.participant import Factory, Participant
from cosim.master.components.python_participant import python_values, read_python, supplied
from cosim.master.fmu.reading import read_description
from cosim.scenario import Kind, Scenario


def read_participants(
    scenario: Scenario,
    clock: Clock,
    problems: Problems,
    instances: Mapping[str, Component] | None = None,
    kinds: Mapping[Kind, Factory] | None = None,
) -> dict[str, Participant]:
    """Read every component; those with a problem are reported and left out.

    ``instances`` holds components that exist already, by name: they are not made from ``source``.
    ``kinds`` makes the components of further kinds, or of one in place of what is here.

    Raises:
        InputError: ``instances`` holds one that stands for nothing.
    """
    _check(instances or {}, scenario)
    found: dict[str, Participant] = {}
    # Each file is looked after once, however many components are made of it.
    bundled, read = cache(_bundled), cache(read_description)
    for name, written in scenario.components.items():
        with problems.at(("components", name)):
            participant = (
                read_fmu(written, bundled, read, clock, problems)
                if written.kind is Kind.FMU
                else read_python(
                    written, problems, supplied(written, scenario, instances or {}, kinds or {})
                )
            )
            clock.check_exact(scenario.ticks, participant.substeps, name)
            found[name] = participant
    return found


def _check(instances: Any, scenario: Scenario) -> None:
    """Refuse what was handed in and would not be used.

    Raises:
        InputError: there is no component of that name, it is an FMU, or what is given is none.
    """
    if not isinstance(instances, Mapping):
        raise InputError(f"components: {instances!r} is no mapping from names to components.")
    for name, given in cast("Mapping[str, Any]", instances).items():
        if name not in scenario.components:
            suggestion = did_you_mean(str(name), scenario.components)
            raise InputError(f"components: there is no component {name}.{suggestion}")
        if scenario.components[name].kind is Kind.FMU:
            raise InputError(
                f"components: {name} is an FMU, which no object stands for; name a class in the "
                f"scenario: components.{name}: {{python: 'module:Class'}}."
            )
        if not isinstance(given, Component):
            raise InputError(
                f"components: for {name} there is {given!r}, which is no component: derive its "
                "class from cohaptic.Component, and make one."
            )


def other_values(
    participant: Participant,
    before: scenarios.ScenarioComponent,
    written: scenarios.ScenarioComponent,
    problems: Problems,
) -> Participant | None:
    """The same component with other parameters and start values than were written ``before``.

    ``None`` where they change what it is: a structural parameter, or a device.

    Raises:
        InputError: no such variable, or a value that does not fit.
    """
    if written.kind is Kind.DEVICE:
        return None
    if participant.component is not None:
        parameters, start = python_values(written, participant.interface, problems)
        return changed(participant, parameters=parameters, start=start)
    description = participant.fmu
    assert description is not None
    structural, variables = Causality.STRUCTURAL_PARAMETER, description.variables
    parameters = fmu_values(written, description, "parameters", written.parameters, problems)
    for name in parameters.keys() | participant.parameters.keys():
        differs = parameters.get(name) != participant.parameters.get(name)
        if differs and name in variables and variables[name].causality is structural:
            return None
    start = participant.start
    if written.start is not before.start:
        start = fmu_values(written, description, "start", written.start, problems)
    return changed(participant, parameters=parameters, start=start)


def _bundled(model: str, flavour: str) -> Path:
    import fmus

    return fmus.find(model, flavour)


def notes_of(participants: Mapping[str, Participant]) -> list[str]:
    """What is worth telling of the components."""
    return [f"{name}: {note}" for name, each in participants.items() for note in each.notes]
