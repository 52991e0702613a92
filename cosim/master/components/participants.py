"""The components of a run: FMUs and Python components behind one small interface."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import Any

from cosim import scenario as scenarios
from cosim.base.component import Causality, Component, Played, Setup
from cosim.base.counter import stream_key
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.master.assembly.clock import Clock
from cosim.master.components import python_component as python
from cosim.master.components.clocks import check_grid
from cosim.master.components.interface import Interface
from cosim.master.components.parameters import SETTABLE, STARTABLE, resolve_values
from cosim.master.components.table import table_of
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.loaded.binary import find_binary
from cosim.master.fmu.loaded.substeps import choose_substeps
from cosim.master.fmu.reading import read_description
from cosim.scenario import Kind, Scenario

Values = dict[str, list[Any]]
Factory = Callable[[scenarios.ScenarioComponent], Component]
"""Makes the component of a kind that is handed in."""


@dataclass(slots=True)
class Participant:
    """A component that was read and checked, but does not run yet."""

    name: str
    period: int
    interface: Interface
    parameters: Values
    start: Values
    fmu: FmuDescription | None = None
    substeps: int = 1
    component: Component | None = None
    """What was asked for its variables; a run takes its own from ``supply``."""
    supply: Supply | None = None
    methods: frozenset[str] = field(default_factory=frozenset[str])
    played: Played | None = None
    is_isolated: bool = False
    """fmu: whether it gets a process of its own."""
    notes: tuple[str, ...] = ()
    """What is worth telling of it."""


class Supply:
    """Gives each run a component of its own: first the one that was read, then others like it.

    One that was handed in, or that stands for a device, there is only once.
    """

    def __init__(self, name: str, first: Component, make: Callable[[], Component] | None) -> None:
        self._name = name
        self._first: Component | None = first
        self._make = make

    def take(self) -> Component:
        """A component that no other run has.

        Raises:
            InputError: there is no other one.
        """
        first, self._first = self._first, None
        if first is not None:
            return first
        if self._make is None:
            raise InputError(
                f"{self._name} exists only once and has served a run: assemble the scenario again "
                "with another one."
            )
        return self._make()


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
    """
    found: dict[str, Participant] = {}
    bundled = cache(_bundled)
    for name, written in scenario.components.items():
        with problems.at(("components", name)):
            participant = (
                _read_fmu(written, bundled, clock, problems)
                if written.kind is Kind.FMU
                else _read_python(
                    written, problems, _supplied(written, scenario, instances or {}, kinds or {})
                )
            )
            clock.check_exact(scenario.ticks, participant.substeps, name)
            found[name] = participant
    return found


def other_values(
    participant: Participant, written: scenarios.ScenarioComponent, problems: Problems
) -> Participant | None:
    """The same component with other parameters and start values.

    ``None`` where they change what it is: a structural parameter, or a device.

    Raises:
        InputError: no such variable, or a value that does not fit.
    """
    if written.kind is Kind.DEVICE:
        return None
    if participant.component is not None:
        parameters, start = _python_values(written, participant.interface, problems)
        return replace(participant, parameters=parameters, start=start)
    description = participant.fmu
    assert description is not None
    structural = {
        name
        for name, variable in description.variables.items()
        if variable.causality is Causality.STRUCTURAL_PARAMETER
    }
    parameters = _values(written, description, "parameters", written.parameters, problems)
    if any(parameters.get(name) != participant.parameters.get(name) for name in structural):
        return None
    start = _values(written, description, "start", written.start, problems)
    return replace(participant, parameters=parameters, start=start)


def setup_of(scenario: Scenario, participant: Participant) -> Setup:
    """What a Python component is told; its seed follows from its name."""
    tick = 1 / scenario.base_rate
    values = {
        name: elements[0] if not participant.interface.variables[name].shape else tuple(elements)
        for name, elements in participant.parameters.items()
        if name in participant.interface.variables
    }
    declared = {
        variable.name: variable.start
        for variable in participant.interface.variables.values()
        if variable.causality is Causality.PARAMETER and variable.start is not None
    }
    written = scenario.components[participant.name].parameters
    return Setup(
        name=participant.name,
        parameters={**declared, **written, **values},
        tick=(tick.numerator, tick.denominator),
        period=participant.period,
        seed=stream_key(scenario.seed, "component", participant.name),
        start_time=float(scenario.start_time),
    )


def _bundled(model: str, flavour: str) -> Path:
    import fmus

    return fmus.find(model, flavour)


def _read_fmu(
    written: scenarios.ScenarioComponent,
    bundled: Callable[[str, str], Path],
    clock: Clock,
    problems: Problems,
) -> Participant:
    own, source = written.is_bundled, written.source
    path = bundled(source, written.flavour) if own else Path(source)
    description = read_description(path)
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
    parameters = _values(written, description, "parameters", structural, problems)
    if parameters:
        sizes = {name: int(elements[0]) for name, elements in parameters.items()}
        description = read_description(path, sizes)
    description = _in_its_mode(description, written, problems)
    others = {k: v for k, v in written.parameters.items() if k not in structural}
    parameters |= _values(written, description, "parameters", others, problems)
    substeps, note = choose_substeps(description, clock, written.period, written.substeps)
    _check_clocks(description, written, written.period * clock.tick / substeps, problems)
    return Participant(
        name=written.name,
        period=written.period,
        interface=description.interface(written.name, feedthrough=bool(written.feedthrough)),
        parameters=parameters,
        start=_values(written, description, "start", written.start, problems),
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


def notes_of(participants: Mapping[str, Participant]) -> list[str]:
    """What is worth telling of the components."""
    return [f"{name}: {note}" for name, each in participants.items() for note in each.notes]


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


def _values(
    written: scenarios.ScenarioComponent,
    description: FmuDescription,
    section: str,
    values: Mapping[str, Any],
    problems: Problems,
) -> Values:
    allowed = SETTABLE if section == "parameters" else STARTABLE
    resolved: Values = {}
    for name, value in values.items():
        with problems.at(("components", written.name, section, name)):
            resolved |= resolve_values(
                written.name, description.variables, name, value, allowed, units=description.units
            )
    return resolved


def _supplied(
    written: scenarios.ScenarioComponent,
    scenario: Scenario,
    instances: Mapping[str, Component],
    kinds: Mapping[Kind, Factory],
) -> tuple[Component, Supply]:
    """A component, and where each run gets its own."""
    given = instances.get(written.name)
    if given is not None:
        return given, Supply(written.name, given, None)
    first = _instance(written, scenario, kinds)
    again = None if written.kind is Kind.DEVICE else partial(_instance, written, scenario, kinds)
    return first, Supply(written.name, first, again)


def _instance(
    written: scenarios.ScenarioComponent, scenario: Scenario, kinds: Mapping[Kind, Factory]
) -> Component:
    """A component of another kind than an FMU.

    Raises:
        InputError: it cannot be had, or nothing here makes its kind.
    """
    if written.kind in kinds:
        return kinds[written.kind](written)
    if written.kind is Kind.DEVICE:
        return python.open_device(written.source, written.options, scenario.safety)
    if written.kind is Kind.PYTHON:
        return python.load_class(written.source, scenario.file.parent)
    if written.kind is Kind.TABLE:
        return table_of(written)
    raise InputError(f"{written.name} is a {written.kind}, which nobody here can run")


def _read_python(
    written: scenarios.ScenarioComponent,
    problems: Problems,
    supplied: tuple[Component, Supply],
) -> Participant:
    component, supply = supplied
    interface = python.interface_of(written.name, component, feedthrough=written.feedthrough)
    parameters, start = _python_values(written, interface, problems)
    return Participant(
        name=written.name,
        period=written.period,
        interface=interface,
        parameters=parameters,
        start=start,
        component=component,
        supply=supply,
        methods=python.methods_of(component),
        played=component.played,
    )


def _python_values(
    written: scenarios.ScenarioComponent, interface: Interface, problems: Problems
) -> tuple[Values, Values]:
    declared = {
        name for name, v in interface.variables.items() if v.causality is Causality.PARAMETER
    }
    parameters: Values = {}
    start: Values = {}
    for name, value in written.parameters.items():
        if not declared or written.kind is Kind.DEVICE:
            break  # it checks its parameters itself
        with problems.at(("components", written.name, "parameters", name)):
            parameters |= resolve_values(written.name, interface.variables, name, value, SETTABLE)
    for name, value in written.start.items():
        with problems.at(("components", written.name, "start", name)):
            start |= resolve_values(written.name, interface.variables, name, value, STARTABLE)
    return parameters, start
