"""``OspSystemStructure.xml`` of the Open Simulation Platform, read as a structure.

Simulators, initial values, connections of variables and of groups (``…_OspModelDescription.xml``),
and linear transformations between them. Sums of signals are refused by name.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.etree import ElementTree as ET
from zipfile import BadZipFile, ZipFile

from cosim.base.errors import InputError
from cosim.ssp.documents import Element, local, number, place, read_xml
from cosim.ssp.parameters import GivenValue, ParameterBinding
from cosim.ssp.structure import SspComponent, SspConnection, SspStructure, SspSystem

OSP = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
_N = {"o": OSP}
_KINDS = {"Real": float, "Integer": int, "String": str}


def read_osp(root: Element, file: Path) -> SspStructure:
    """The structure that it describes.

    Raises:
        InputError: it uses what cannot be used here, with its place.
    """
    system = SspSystem("root", {}, [])
    step = root.findtext("o:BaseStepSize", None, _N)
    for each in root.findall("o:Simulators/o:Simulator", _N):
        name = each.get("name", "")
        source = file.parent / each.get("source", "").removeprefix("file:")
        system.elements[name] = SspComponent(
            name=name,
            source=source,
            kinds=_causalities(source),
            bindings=[_initial_values(each, file)],
            step=each.get("stepSize") or step,
            own={},
            element=each,
        )
    functions = {each.get("name", ""): each for each in root.findall("o:Functions/*", _N)}
    for each in root.findall("o:Connections/*", _N):
        system.connections += _connections(each, system, file)
    system.connections += _through_functions(root, functions, file)
    return SspStructure(
        file=file,
        title=file.parent.name,
        system=system,
        start=root.findtext("o:StartTime", None, _N),
        stop=root.findtext("o:EndTime", None, _N),
        step=step,
        own={},
    )


def _causalities(source: Path) -> dict[str, str]:
    """Of an FMU's variables, whatever its version; empty where it cannot be read."""
    try:
        with ZipFile(source) as archive:
            root = ET.fromstring(archive.read("modelDescription.xml"))
    except (OSError, KeyError, BadZipFile, ET.ParseError):
        return {}
    variables = root.find("ModelVariables")
    return {
        each.get("name", ""): each.get("causality", "local")
        for each in (variables if variables is not None else ())
    }


def _initial_values(simulator: Element, file: Path) -> ParameterBinding:
    values: dict[str, GivenValue] = {}
    for each in simulator.findall("o:InitialValues/o:InitialValue", _N):
        for child in each:
            text = child.get("value", "")
            kind = local(child)
            try:
                value = text in {"true", "1"} if kind == "Boolean" else _KINDS.get(kind, str)(text)
            except ValueError:
                raise InputError(f"'{text}' is no {kind}.", place(file, child)) from None
            values[each.get("variable", "")] = GivenValue(value, None)
    return ParameterBinding(values, ())


def _connections(element: Element, system: SspSystem, file: Path) -> Iterator[SspConnection]:
    kind = local(element)
    if kind == "VariableConnection":
        yield _plain(element, *(_end(each) for each in element))
    elif kind == "VariableGroupConnection":
        groups = [_group(each, system, file) for each in element]
        if len(groups) != 2 or len(groups[0]) != len(groups[1]):
            raise InputError(
                "the groups of a connection have different numbers of variables.",
                place(file, element),
            )
        for start, end in zip(*groups, strict=True):
            yield _plain(element, start, end)
    elif kind != "SignalConnection":
        raise InputError(f"a {kind} cannot be used here.", place(file, element))


def _end(element: Element) -> tuple[str | None, str]:
    return element.get("simulator"), element.get("name", "")


def _plain(
    element: Element, start: tuple[str | None, str], end: tuple[str | None, str]
) -> SspConnection:
    return SspConnection(start, end, 1.0, 0.0, True, {}, element)


def _group(element: Element, system: SspSystem, file: Path) -> list[tuple[str | None, str]]:
    """The variables of a group, in order, those of groups in it included."""
    simulator, name = _end(element)
    component = system.elements.get(simulator or "")
    if not isinstance(component, SspComponent):
        raise InputError(f"there is no simulator '{simulator}'.", place(file, element))
    stem = component.source.stem
    beside = [
        folder / f"{stem}_OspModelDescription.xml"
        for folder in (component.source.parent, file.parent)
    ]
    for path in beside:
        if path.is_file():
            for group in read_xml(path).iter():
                if isinstance(group.tag, str) and group.get("name") == name and len(group):
                    variables = [e for e in group.iter() if local(e) == "Variable"]
                    return [(simulator, each.get("ref", "")) for each in variables]
    raise InputError(
        f"no {stem}_OspModelDescription.xml says what the group '{name}' is.", place(file, element)
    )


def _through_functions(
    root: Element, functions: dict[str, Element], file: Path
) -> Iterator[SspConnection]:
    """Connections whose value passes a linear transformation, as one connection each."""
    into: dict[str, tuple[str | None, str]] = {}
    out: list[tuple[str, tuple[str | None, str], Element]] = []
    for each in root.findall("o:Connections/o:SignalConnection", _N):
        variable, signal = each.find("o:Variable", _N), each.find("o:Signal", _N)
        name = signal.get("function", "")
        function = functions.get(name)
        if function is None or local(function) != "LinearTransformation":
            what = "there is no function" if function is None else f"a {local(function)}"
            raise InputError(f"{what} '{name}' cannot be used here.", place(file, each))
        if signal.get("name") == "in":
            into[name] = _end(variable)
        else:
            out.append((name, _end(variable), each))
    for name, target, element in out:
        if name in into:
            factor = number(functions[name], "factor", "1", file)
            offset = number(functions[name], "offset", "0", file)
            yield SspConnection(into[name], target, factor, offset, True, {}, element)
