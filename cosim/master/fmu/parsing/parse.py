"""An FMU's modelDescription.xml and terminals, read into what the master works with."""

from __future__ import annotations

import importlib
import math
import xml.etree.ElementTree as ET
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.component import Variable
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import decimal, exact, simple
from cosim.base.quantities.units import BASES, Unit, unit_of
from cosim.master.components.clocks import read_clocks
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.meanings import NOTHING, read_meanings
from cosim.master.fmu.parsing.model_structure import (
    among,
    dependencies_of,
    direct_dependencies,
    inputs_of,
    terminals_of,
)
from cosim.master.fmu.parsing.variables import Shapes, relative_quantities, text_starts, variable_of
from cosim.master.fmu.rules import judge

DESCRIPTION = "modelDescription.xml"


def parse_description(
    path: Path, folder: Path, digest: str, structure: tuple[tuple[str, int], ...]
) -> FmuDescription:
    """Read the unpacked ``folder`` of the FMU at ``path``, whose SHA-256 is ``digest``.

    ``structure`` gives structural parameters other values than their start; arrays follow.

    Raises:
        InputError: the description cannot be used.
    """
    description, breaks = _parse(path, folder)
    version = description.fmiMajorVersion
    interface = description.coSimulation
    if interface is None:
        raise InputError(f"{path} offers no co-simulation; {_offered(description)}")
    experiment = description.defaultExperiment
    by_reference = {v.valueReference: v.name for v in description.modelVariables}
    shapes = Shapes(dict(structure), by_reference)
    meant = read_meanings(path, folder / DESCRIPTION)
    relative = relative_quantities(folder / DESCRIPTION)
    variables: dict[str, Variable] = {}
    texts = text_starts(folder / DESCRIPTION, version)
    clocked = {
        v.name: tuple(of.name for of in v.clocks)
        for v in description.modelVariables
        if v.clocks and v.type != "Clock"
    }
    skipped = {
        v.name: str(v.causality)
        for v in description.modelVariables
        if v.name in clocked or v.type == "Clock"
    }
    for v in description.modelVariables:
        if v.type == "Clock":
            continue
        try:
            variables[v.name] = variable_of(
                v,
                version,
                shapes,
                meant.get(v.name, NOTHING),
                is_relative=relative.get(v.name),
                texts=texts.get(v.name, ()),
            )
        except ValueError as error:
            raise InputError(
                f"line {v.sourceline} of the modelDescription.xml of {path}: {v.name}: {error}"
            ) from None
    at_events = [variables.pop(name) for name in clocked]
    breaks += judge(description, path, folder, is_valid=not breaks)
    terminals, wrong = terminals_of(folder, variables, skipped)
    return FmuDescription(
        path=path,
        folder=folder,
        sha256=digest,
        version=version,
        model_identifier=interface.modelIdentifier,
        token=description.guid,
        variables=variables,
        references={v.name: v.valueReference for v in description.modelVariables},
        dimensions={
            v.name: tuple(by_reference.get(d.valueReference) for d in v.dimensions)
            for v in description.modelVariables
            if v.dimensions
        },
        dependencies=among(variables, direct_dependencies(description)),
        initial_dependencies=among(
            variables, dependencies_of(description.initialUnknowns, inputs_of(description))
        ),
        terminals=terminals,
        units={u.name: _unit(u, path) for u in description.unitDefinitions},
        log_categories=tuple(c.name for c in description.logCategories),
        varies_step=bool(interface.canHandleVariableCommunicationStepSize),
        fixed_step=_fixed_step(description),
        step_size=_time(experiment.stepSize if experiment else None)
        or _time(interface.fixedInternalStepSize),
        start_time=_instant(experiment.startTime if experiment else None),
        stop_time=_time(experiment.stopTime if experiment else None),
        calculated=tuple(
            v.name
            for v in description.modelVariables
            if v.initial == "calculated" and v.causality in {"output", "local"}
        ),
        once_per_process=interface.canBeInstantiatedOnlyOncePerProcess,
        breaks=breaks + wrong,
        skipped=skipped,
        has_event_mode=version == 3 and bool(interface.hasEventMode),
        clocks=read_clocks(ET.parse(folder / DESCRIPTION).getroot()) if skipped else [],
        at_events=tuple(each for each in at_events if not each.type.is_text),
        clocked=clocked,
        at_start=tuple(u.variable.name for u in description.initialUnknowns),
        events=None,
        needs_tool=interface.needsExecutionTool,
        saves_state=interface.canGetAndSetFMUstate and interface.canSerializeFMUstate,
    )


def _offered(description: Any) -> str:
    """What an FMU without co-simulation is, and what to do."""
    if description.modelExchange is not None:
        return (
            "export it for co-simulation (it is for model exchange, so that it brings no solver of "
            "its own)"
        )
    if description.scheduledExecution is not None:
        return (
            "export it for co-simulation (it is for scheduled execution, where the importer "
            "activates each of its clocks' partitions)"
        )
    return "its modelDescription.xml has no element CoSimulation"


def _parse(path: Path, folder: Path) -> tuple[Any, tuple[str, ...]]:
    """FMPy's description, and the rules that it breaks: many tools break some."""
    fmpy: Any = importlib.import_module("fmpy.model_description")
    file = folder / DESCRIPTION
    if file.is_dir():
        raise InputError(f"modelDescription.xml of {path} is a folder, so it is not an FMU")
    if not file.is_file():
        raise InputError(f"{path} has no modelDescription.xml at its top, so it is not an FMU")
    _check_version(path, file)
    try:
        try:
            return fmpy.read_model_description(str(folder)), ()
        except fmpy.ValidationError as error:
            breaks = tuple(str(problem) for problem in error.problems)
        found = fmpy.read_model_description(str(folder), validate=False)
    except Exception as error:  # FMPy raises bare exceptions, lxml its own
        said = _reason(error, file)
        raise InputError(f"the modelDescription.xml of {path} cannot be read: {said}") from None
    return found, breaks


def _check_version(path: Path, file: Path) -> None:
    """Before a reader of two versions stumbles over another one.

    Raises:
        InputError: it is no description of FMI 2 or 3.
    """
    try:
        root = next(ET.iterparse(file, events=("start",)))[1]
    except (ET.ParseError, LookupError, ValueError):
        return  # the reader says where
    if root.tag != "fmiModelDescription":
        raise InputError(
            f"the modelDescription.xml of {path} begins with <{root.tag}>, so it is not an FMU's"
        )
    said = root.get("fmiVersion")
    if said is None:
        raise InputError(f"the modelDescription.xml of {path} does not say its fmiVersion")
    if said.partition(".")[0] not in {"2", "3"}:
        raise InputError(f"{path} is an FMU of FMI {said}; export it again as FMI 2.0 or 3.0")


def _reason(error: Exception, file: Path) -> str:
    """In words, where FMPy looks something up that is not there."""
    if isinstance(error, IndexError):
        return "its ModelStructure has an index that is beyond the last variable"
    if isinstance(error, KeyError) and error.args[0] is not None:
        return f"no variable has the valueReference {error.args[0]}, which it refers to"
    if isinstance(error, KeyError):
        return "a Dimension has neither a start nor a valueReference"
    if isinstance(error, TypeError) and ET.parse(file).find("ModelVariables") is None:
        return "it has no ModelVariables"
    if isinstance(error, TypeError):
        return "a number that the standard requires is missing (a valueReference, for one)"
    return str(error)


def _unit(unit: Any, path: Path) -> Unit:
    base = unit.baseUnit
    if base is None:
        return unit_of(unit.name)
    try:
        exponents = tuple(int(getattr(base, name)) for name in BASES)
        found = Unit(unit.name, exponents, exact(float(base.factor)), exact(float(base.offset)))
    except ValueError:
        found = None
    if found is None or not found.factor:
        raise InputError(
            f"the modelDescription.xml of {path}: nothing converts to its unit {unit.name}: one of "
            "the powers is no whole number, or the factor or the offset none, or the factor is 0"
        )
    return found


def _fixed_step(description: Any) -> Fraction | None:
    interface = description.coSimulation
    if interface.canHandleVariableCommunicationStepSize:
        return None
    experiment = description.defaultExperiment
    return _time(interface.fixedInternalStepSize or (experiment.stepSize if experiment else None))


def _instant(text: Any) -> Fraction | None:
    """A time (s), which may lie before 0, where there is one."""
    if text is None or not math.isfinite(float(text)):
        return None
    return simple(decimal(str(text)))


def _time(text: Any) -> Fraction | None:
    """A time above 0 (s), where there is one."""
    found = _instant(text)
    return found if found is not None and found > 0 else None
