"""An SSD as it is written: systems in systems, components, connectors, connections, bindings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote

from cosim.base.document.yaml_reader import parse_yaml
from cosim.base.errors import InputError
from cosim.base.quantities.units import Unit
from cosim.ssp.documents import (
    NAMESPACES,
    OSP_TYPES,
    OWN,
    OWN_TYPE,
    Element,
    local,
    place,
    transformation,
)
from cosim.ssp.parameters import ParameterBinding, read_bindings, read_units

FMU_TYPE = "application/x-fmu-sharedlibrary"
_SINKS = frozenset({"input", "parameter", "structuralParameter", "inout"})


@dataclass(slots=True)
class SspConnection:
    """Two ends, each an element's name (``None``: the system itself) and a connector."""

    start: tuple[str | None, str]
    end: tuple[str | None, str]
    factor: float
    offset: float
    ignores_unit: bool
    own: dict[str, str]
    element: Element


@dataclass(slots=True)
class SspComponent:
    """An FMU."""

    name: str
    source: Path
    kinds: dict[str, str]
    """The kind of each connector."""
    bindings: list[ParameterBinding]
    step: str | None
    """A step (s) that OSP's annotations suggest."""
    own: dict[str, str]
    """What our annotation says."""
    element: Element
    units: dict[str, str] = field(default_factory=dict[str, str])
    """The unit's name of each connector that says one."""
    types: dict[str, str] = field(default_factory=dict[str, str])
    """The type of each connector that says one."""


@dataclass(slots=True)
class SspSystem:
    """A system with what is in it."""

    name: str
    kinds: dict[str, str]
    bindings: list[ParameterBinding]
    elements: dict[str, SspComponent | SspSystem] = field(default_factory=dict[str, Any])
    connections: list[SspConnection] = field(default_factory=list[SspConnection])
    units: dict[str, str] = field(default_factory=dict[str, str])
    """The unit's name of each connector that says one."""


@dataclass(slots=True)
class SspStructure:
    """A whole SSD."""

    file: Path
    title: str
    system: SspSystem
    start: str | None
    stop: str | None
    step: str | None
    own: dict[str, Any]
    """The scenario without components and connections, where we have written it."""
    units: dict[str, Unit] = field(default_factory=dict[str, Unit])
    """Those that are defined, by name."""


def read_structure(root: Element, file: Path) -> SspStructure:
    """The structure that an SSD describes.

    Raises:
        InputError: it uses what cannot be used here, with its place.
    """
    system = root.find("ssd:System", NAMESPACES)
    if system is None:
        raise InputError("there is no System.", place(file, root))
    experiment = root.find("ssd:DefaultExperiment", NAMESPACES)
    at = root if experiment is None else experiment
    algorithm = next(
        (e for a in _osp(at) for e in a.iter() if local(e) == "FixedStepAlgorithm"), None
    )
    return SspStructure(
        file=file,
        title=root.get("name", ""),
        system=_system(system, file),
        start=None if experiment is None else experiment.get("startTime"),
        stop=None if experiment is None else experiment.get("stopTime"),
        step=None if algorithm is None else algorithm.get("baseStepSize"),
        own=_own_scenario(system),
        units=read_units(root.find("ssd:Units", NAMESPACES), file),
    )


def is_sink(kind: str, *, outside: bool) -> bool:
    """Whether a connector takes values: of an element seen from outside, or a system's own."""
    return (kind in _SINKS) is outside


def _system(element: Element, file: Path) -> SspSystem:
    _refuse_dictionaries(element, file)
    system = SspSystem(
        element.get("name", ""),
        _kinds(element),
        read_bindings(element, file.parent, file),
        units=_units(element),
    )
    for child in element.findall("ssd:Elements/*", NAMESPACES):
        name = child.get("name", "")
        if name in system.elements:
            raise InputError(f"there are two elements '{name}'.", place(file, child))
        kind = local(child)
        if kind == "System":
            system.elements[name] = _system(child, file)
        elif kind == "Component":
            system.elements[name] = _component(child, file)
    system.connections = [
        _connection(each, file)
        for each in element.findall("ssd:Connections/ssd:Connection", NAMESPACES)
    ]
    return system


def _refuse_dictionaries(element: Element, file: Path) -> None:
    for path in ("ssd:SignalDictionaries/*", "ssd:Elements/ssd:SignalDictionaryReference"):
        found = element.find(path, NAMESPACES)
        if found is not None:
            raise InputError(
                f"the signal dictionary '{found.get('name')}' cannot be used here; connect the "
                "components themselves.",
                place(file, found),
            )


def _component(element: Element, file: Path) -> SspComponent:
    name, kind = element.get("name", ""), element.get("type", FMU_TYPE)
    source = element.get("source")
    if kind != FMU_TYPE or source is None:
        what = "without a source" if source is None else f"of type {kind}"
        raise InputError(
            f"the component '{name}' is {what}; only FMUs can be run.", place(file, element)
        )
    implementation = element.get("implementation", "any")
    if implementation not in {"any", "CoSimulation"}:
        raise InputError(
            f"the component '{name}' is for {implementation}, not for co-simulation.",
            place(file, element),
        )
    path = file.parent / unquote(source.removeprefix("file:").partition("#")[0])
    hint = next((e for a in _osp(element) for e in a.iter() if local(e) == "StepSizeHint"), None)
    return SspComponent(
        name=name,
        source=path,
        kinds=_kinds(element),
        bindings=read_bindings(element, path, file),
        step=None if hint is None else hint.get("value"),
        own=_own(element, "Component"),
        element=element,
        units=_units(element),
        types=_types(element),
    )


def _connection(element: Element, file: Path) -> SspConnection:
    factor, offset = transformation(element, file)
    ends = {
        end: (
            element.get(f"{end}Element") or None,
            element.get(f"{end}Connector", "") + _indices(element.get(f"{end}Indices")),
        )
        for end in ("start", "end")
    }
    return SspConnection(
        start=ends["start"],
        end=ends["end"],
        factor=factor,
        offset=offset,
        ignores_unit=element.get("suppressUnitConversion") in {"true", "1"},
        own=_own(element, "Connection"),
        element=element,
    )


def _indices(text: str | None) -> str:
    return f"[{','.join(text.split())}]" if text else ""


def _kinds(element: Element) -> dict[str, str]:
    return {
        each.get("name", ""): each.get("kind", "unspecified")
        for each in element.findall("ssd:Connectors/ssd:Connector", NAMESPACES)
    }


def _units(element: Element) -> dict[str, str]:
    found: dict[str, str] = {}
    for each in element.findall("ssd:Connectors/ssd:Connector", NAMESPACES):
        for kind in each:
            if unit := kind.get("unit"):
                found[each.get("name", "")] = unit
    return found


def _types(element: Element) -> dict[str, str]:
    return {
        each.get("name", ""): local(kind)
        for each in element.findall("ssd:Connectors/ssd:Connector", NAMESPACES)
        for kind in each
        if local(kind) not in {"Dimension", "Annotations"}
    }


def _annotations(element: Element) -> Iterator[Element]:
    yield from element.findall("ssd:Annotations/ssc:Annotation", NAMESPACES)


def _osp(element: Element) -> Iterator[Element]:
    for each in _annotations(element):
        if each.get("type") in OSP_TYPES:
            yield each


def _own(element: Element, name: str) -> dict[str, str]:
    for each in _annotations(element):
        if each.get("type") == OWN_TYPE:
            found = each.find(f"{{{OWN}}}{name}")
            if found is not None:
                return dict(found.attrib)
    return {}


def _own_scenario(system: Element) -> dict[str, Any]:
    for each in _annotations(system):
        if each.get("type") == OWN_TYPE:
            text = each.findtext(f"{{{OWN}}}Scenario")
            if text:
                found: Any = parse_yaml(text, "the annotation", has_lines=False).plain()
                return cast("dict[str, Any]", found) if isinstance(found, dict) else {}
    return {}
