"""An FMU's modelDescription.xml and terminals, read into what the master works with."""

from __future__ import annotations

import importlib
import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.component import Causality, Variable, VariableType
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import exact
from cosim.base.quantities.units import BASES, Unit, unit_of
from cosim.master.components.clocks import (
    MOST_CLOCKS,
    ClockFacts,
    EventFacts,
    check_membership,
    clock_facts,
    clock_variables,
    read_clocks,
)
from cosim.master.components.interface import Interface
from cosim.master.components.parameters import misfit
from cosim.master.fmu.meanings import NOTHING, Meant, read_meanings
from cosim.master.fmu.rules import judge

_TRUTHS = {"true": True, "1": True, "false": False, "0": False}
_FMI2_TYPES = {
    "Real": VariableType.FLOAT64,
    "Integer": VariableType.INT32,
    "Enumeration": VariableType.ENUMERATION,
    "Boolean": VariableType.BOOLEAN,
    "String": VariableType.STRING,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuDescription:
    """Everything about an FMU that is known without running it."""

    path: Path
    folder: Path
    sha256: str
    version: int
    model_identifier: str
    token: str
    variables: Mapping[str, Variable]
    references: Mapping[str, int]
    """Value reference by variable name."""
    dimensions: Mapping[str, tuple[str | None, ...]]
    """For each array, the structural parameter behind each dimension."""
    dependencies: Mapping[str, tuple[str, ...]]
    initial_dependencies: Mapping[str, tuple[str, ...]]
    terminals: Mapping[str, Mapping[str, str]]
    units: Mapping[str, Unit]
    log_categories: tuple[str, ...]
    varies_step: bool
    """Whether its steps may have any length."""
    fixed_step: Fraction | None
    """The step (s) that an FMU which cannot vary its step was made for."""
    step_size: Fraction | None
    """The step (s) that the FMU suggests, by its default experiment or its own steps."""
    stop_time: Fraction | None
    """How long (s) its default experiment lasts."""
    once_per_process: bool
    breaks: tuple[str, ...]
    """Rules of the standard that the description breaks, and with which it can be used."""
    skipped: Mapping[str, str]
    """The clocked variables, which have values in event mode alone, and their causality."""
    has_event_mode: bool
    clocks: list[dict[str, Any]]
    """The clocks, as ``read_clocks`` found them."""
    at_events: tuple[Variable, ...]
    """Numbers that belong to clocks."""
    clocked: Mapping[str, tuple[str, ...]]
    """The clocks of each clocked variable."""
    at_start: tuple[str, ...]
    """The clocked variables that have a value in initialisation mode."""
    events: EventFacts | None
    """What to do at events, where event mode is used."""
    needs_tool: bool
    """Whether its library only talks to a tool that has to be installed."""
    saves_state: bool
    """Whether it offers its whole state as bytes, and takes it back."""

    def interface(self, component: str, *, feedthrough: bool) -> Interface:
        """The FMU as a component of that name."""
        return Interface(
            component=component,
            variables=self.variables,
            feedthrough=feedthrough,
            dependencies=self.dependencies,
            initial_dependencies=self.initial_dependencies,
            terminals=self.terminals,
            units=self.units,
            skipped=frozenset(self.skipped),
            events=self.events,
        )

    def in_mode(self, wanted: bool | None) -> FmuDescription:
        """With its event mode in use, where it is wanted; by default where there are clocks.

        Then clocks and what belongs to them are among the variables.

        Raises:
            InputError: a clock's ticks do not follow from what it says, or there are too many.
        """
        if not (self.has_event_mode and (bool(self.clocks) if wanted is None else wanted)):
            return self
        try:
            clocks = self._clocks()
        except InputError as error:
            raise InputError(
                f"the FMU {self.path.name}: {error.message}; 'event_mode: false' leaves its clocks "
                "out"
            ) from None
        clocked = {each.name: each for each in self.at_events}
        variables = {**self.variables, **clocked}
        variables |= {each.name: each for each in clock_variables(clocks)}
        own = [name for name in variables if name not in self.variables]
        return replace(
            self,
            variables=variables,
            references={**self.references, **dict.fromkeys(set(own) - set(self.references), 0)},
            dependencies={**self.dependencies, **dict.fromkeys(own, ())},
            initial_dependencies={**self.initial_dependencies, **dict.fromkeys(own, ())},
            skipped={name: why for name, why in self.skipped.items() if name not in variables},
            events=EventFacts(
                clocks=clocks,
                clocked={name: self.clocked[name] for name in clocked},
                at_start=frozenset(self.at_start),
                may_return=self.varies_step,
            ),
        )

    def _clocks(self) -> tuple[ClockFacts, ...]:
        clocks = tuple(clock_facts(written, self.references) for written in self.clocks)
        if len(clocks) > MOST_CLOCKS:
            raise InputError(f"it has {len(clocks)} clocks; up to {MOST_CLOCKS} are driven")
        check_membership(clocks, self.clocked)
        return clocks


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
    if version not in {2, 3}:
        raise InputError(
            f"{path} is an FMU of FMI {description.fmiVersion}; export it again as FMI 2.0 or 3.0"
        )
    interface = description.coSimulation
    if interface is None:
        raise InputError(f"{path} offers no co-simulation; {_offered(description)}")
    experiment = description.defaultExperiment
    by_reference = {v.valueReference: v.name for v in description.modelVariables}
    shapes = _Shapes(dict(structure), by_reference)
    meant = read_meanings(path, folder / "modelDescription.xml")
    relative = _relative(folder / "modelDescription.xml")
    variables: dict[str, Variable] = {}
    texts = _text_starts(folder / "modelDescription.xml", version)
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
            variables[v.name] = _variable(
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
        dependencies=_among(variables, _direct_dependencies(description)),
        initial_dependencies=_among(
            variables, _dependencies(description.initialUnknowns, _inputs(description))
        ),
        terminals=_terminals(folder, variables),
        units={u.name: _unit(u) for u in description.unitDefinitions},
        log_categories=tuple(c.name for c in description.logCategories),
        varies_step=bool(interface.canHandleVariableCommunicationStepSize),
        fixed_step=_fixed_step(description),
        step_size=_time(experiment.stepSize if experiment else None)
        or _time(interface.fixedInternalStepSize),
        stop_time=_time(experiment.stopTime if experiment else None),
        once_per_process=interface.canBeInstantiatedOnlyOncePerProcess,
        breaks=breaks,
        skipped=skipped,
        has_event_mode=version == 3 and bool(interface.hasEventMode),
        clocks=read_clocks(ET.parse(folder / "modelDescription.xml").getroot()) if skipped else [],
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
    file = folder / "modelDescription.xml"
    if file.is_dir():
        raise InputError(f"modelDescription.xml of {path} is a folder, so it is not an FMU")
    if not file.is_file():
        raise InputError(f"{path} has no modelDescription.xml at its top, so it is not an FMU")
    try:
        try:
            return fmpy.read_model_description(str(folder)), ()
        except fmpy.ValidationError as error:
            breaks = tuple(str(problem) for problem in error.problems)
        found = fmpy.read_model_description(str(folder), validate=False)
    except Exception as error:  # FMPy raises bare exceptions, lxml its own
        said = _reason(error)
        raise InputError(f"the modelDescription.xml of {path} cannot be read: {said}") from None
    return found, breaks


def _reason(error: Exception) -> str:
    """In words, where FMPy looks something up that is not there."""
    if isinstance(error, IndexError):
        return "its ModelStructure has an index that is beyond the last variable"
    if isinstance(error, KeyError) and error.args[0] is not None:
        return f"no variable has the valueReference {error.args[0]}, which it refers to"
    if isinstance(error, KeyError):
        return "a Dimension has neither a start nor a valueReference"
    if isinstance(error, TypeError):
        return "a number that the standard requires is missing (a valueReference, for one)"
    return str(error)


@dataclass(frozen=True, slots=True)
class _Shapes:
    structure: Mapping[str, int]
    by_reference: Mapping[int, str]

    def of(self, variable: Any) -> tuple[int, ...]:
        shape = list[int](variable.shape or ())
        for place, dimension in enumerate(variable.dimensions):
            name = self.by_reference.get(dimension.valueReference, "")
            if name in self.structure:
                shape[place] = self.structure[name]
        return tuple(shape)


def _variable(
    variable: Any,
    version: int,
    shapes: _Shapes,
    meant: Meant,
    *,
    is_relative: bool | None,
    texts: tuple[str, ...],
) -> Variable:
    kind = _FMI2_TYPES[variable.type] if version == 2 else VariableType(variable.type)
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared is not None else None)
    items = {item.name: int(item.value) for item in declared.items} if declared is not None else {}
    return Variable(
        name=variable.name,
        type=kind,
        causality=Causality(variable.causality),
        variability=variable.variability,
        unit=unit,
        start=_text_start(texts or variable.start, kind)
        if kind.is_text
        else _start(variable.start, kind),
        shape=shapes.of(variable),
        minimum=_bound(variable.min),
        maximum=_bound(variable.max),
        description=variable.description or "",
        items=items or None,
        is_relative=is_relative
        if is_relative is not None
        else bool(declared is not None and declared.relativeQuantity),
        meaning=meant.meaning,
        belongs_to=meant.belongs_to,
    )


def _relative(path: Path) -> dict[str, bool]:
    """What variables say of ``relativeQuantity`` themselves, which FMPy passes over."""
    if b"relativeQuantity" not in path.read_bytes():
        return {}
    found: dict[str, bool] = {}
    for variable in ET.parse(path).getroot().iterfind("ModelVariables/*"):
        for element in (variable, *variable.findall("Real")):
            if (word := element.get("relativeQuantity")) is not None:
                found[variable.get("name", "")] = word in {"true", "1"}
    return found


def _text_starts(path: Path, version: int) -> dict[str, tuple[str, ...]]:
    """The starts of FMI 3's Strings and Binaries, of which FMPy reads an array's first alone."""
    if version == 2 or b"<Start" not in path.read_bytes():
        return {}
    variables = ET.parse(path).getroot().iterfind("ModelVariables/*")
    return {
        variable.get("name", ""): tuple(start.get("value", "") for start in starts)
        for variable in variables
        if (starts := variable.findall("Start"))
    }


def _text_start(given: Any, kind: VariableType) -> Any:
    """One text (or bytes, in XML hexadecimal) for all elements, or one for each.

    Raises:
        ValueError: it is not hexadecimal.
    """
    if given is None:
        return None
    texts: tuple[str, ...] = (given,) if isinstance(given, str) else given
    if kind is VariableType.STRING:
        return texts[0] if len(texts) == 1 else texts
    try:
        contents = tuple(bytes.fromhex(text) for text in texts)
    except ValueError:
        raise ValueError("its start is not hexadecimal, as that of a Binary has to be") from None
    return contents[0] if len(contents) == 1 else contents


def _bound(text: str | None) -> float | None:
    return None if text is None else float(text)


def _start(text: str | None, kind: VariableType) -> Any:
    if text is None:
        return None
    values = [_scalar(word, kind) for word in text.split()]
    return values[0] if len(values) == 1 else tuple(values)


def _scalar(word: str, kind: VariableType) -> float | int | bool:
    """One value of XML.

    Raises:
        ValueError: it is none of that type.
    """
    if kind is VariableType.BOOLEAN:
        if word not in _TRUTHS:
            raise ValueError(f"its start, {word}, is neither true nor false")
        return _TRUTHS[word]
    try:
        value = float(word) if kind.is_float else int(word)
    except ValueError:
        raise ValueError(f"its start, {word}, is not of type {kind}") from None
    if problem := misfit(kind, value):
        raise ValueError(f"its start is {problem}")
    return value


def _among(
    variables: Mapping[str, Variable], dependencies: Mapping[str, tuple[str, ...]]
) -> dict[str, tuple[str, ...]]:
    """Those of the variables that are used, on such."""
    return {
        name: tuple(other for other in others if other in variables)
        for name, others in dependencies.items()
        if name in variables
    }


def _direct_dependencies(description: Any) -> dict[str, tuple[str, ...]]:
    """Of every output; one that the model structure leaves out may depend on anything."""
    inputs = _inputs(description)
    outputs = {v.name: inputs for v in description.modelVariables if v.causality == "output"}
    return outputs | _dependencies(description.outputs, inputs)


def _dependencies(unknowns: list[Any], inputs: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
    """Direct dependencies on inputs: all of them where the attribute is absent, none where empty.

    FMI 2.0 section 2.2.8, FMI 3.0 section 2.4.8.
    """
    return {
        unknown.variable.name: inputs
        if unknown.dependencies is None
        else tuple(v.name for v in unknown.dependencies if v.causality == "input")
        for unknown in unknowns
    }


def _inputs(description: Any) -> tuple[str, ...]:
    return tuple(v.name for v in description.modelVariables if v.causality == "input")


def _terminals(folder: Path, variables: Mapping[str, Variable]) -> dict[str, dict[str, str]]:
    """FMI 3.0 section 2.4.9; nested terminals get dotted names."""
    path = folder / "terminalsAndIcons" / "terminalsAndIcons.xml"
    if not path.is_file():
        return {}
    try:
        root = ET.parse(path).getroot()
    except ET.ParseError:
        return {}
    found: dict[str, dict[str, str]] = {}

    def visit(element: ET.Element, prefix: str) -> None:
        for terminal in element.findall("Terminal"):
            name = prefix + terminal.get("name", "")
            members = {
                member.get("memberName") or member.get("variableName", ""): variable
                for member in terminal.findall("TerminalMemberVariable")
                if (variable := member.get("variableName", "")) in variables
            }
            if members:
                found[name] = members
            visit(terminal, f"{name}.")

    terminals = root.find("Terminals")
    if terminals is not None:
        visit(terminals, "")
    return found


def _unit(unit: Any) -> Unit:
    base = unit.baseUnit
    if base is None:
        return unit_of(unit.name)
    exponents = tuple(int(getattr(base, name)) for name in BASES)
    return Unit(unit.name, exponents, exact(float(base.factor)), exact(float(base.offset)))


def _fixed_step(description: Any) -> Fraction | None:
    interface = description.coSimulation
    if interface.canHandleVariableCommunicationStepSize:
        return None
    experiment = description.defaultExperiment
    return _time(interface.fixedInternalStepSize or (experiment.stepSize if experiment else None))


def _time(text: Any) -> Fraction | None:
    """A time above 0 (s), where there is one."""
    if text is None or not 0 < float(text) < math.inf:
        return None
    exact = Fraction(str(text))
    near = exact.limit_denominator(1_000_000)
    # 0.3333333333 was written for 1/3; an exact value stays what it is.
    return near if abs(near - exact) <= abs(exact) * Fraction(1, 10**9) else exact
