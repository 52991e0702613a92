"""A component of Python, a device, a table or what is handed in: made, and given its values."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from cosim import scenario as scenarios
from cosim.base.component import Causality, Component
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.master.components import python_component as python
from cosim.master.components.interface import Interface
from cosim.master.components.parameters import SETTABLE, STARTABLE, resolve_values
from cosim.master.components.participant import Factory, Participant, Supply, Values
from cosim.master.components.table import table_of
from cosim.scenario import Kind, Scenario


def supplied(
    written: scenarios.ScenarioComponent,
    scenario: Scenario,
    instances: Mapping[str, Component],
    kinds: Mapping[Kind, Factory],
) -> tuple[Component, Supply]:
    """A component, and where each run gets its own.

    Raises:
        InputError: it cannot be had.
    """
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
        return table_of(written, scenario)
    raise InputError(f"{written.name} is a {written.kind}, which nobody here can run")


def read_python(
    written: scenarios.ScenarioComponent,
    problems: Problems,
    taken: tuple[Component, Supply],
) -> Participant:
    """What ``supplied`` found, with its variables and its values.

    Raises:
        InputError: it does not say what it needs.
    """
    component, supply = taken
    interface = python.interface_of(written.name, component, feedthrough=written.feedthrough)
    parameters, start = python_values(written, interface, problems)
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


def python_values(
    written: scenarios.ScenarioComponent, interface: Interface, problems: Problems
) -> tuple[Values, Values]:
    """Parameters and start values; what does not fit is reported and left out."""
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
