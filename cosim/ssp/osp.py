"""``OspSystemStructure.xml`` of the Open Simulation Platform, read as a structure.

Simulators, initial values, connections of variables and of groups (``…_OspModelDescription.xml``),
and linear transformations between them. Sums of signals are refused by name.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote
from xml.etree import ElementTree as ET
from zipfile import BadZipFile, ZipFile

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.ssp.documents import Element, local, number, place, read_xml
from cosim.ssp.parameters import GivenValue, ParameterBinding
from cosim.ssp.structure import SspComponent, SspConnection, SspStructure, SspSystem

OSP = "http://opensimulationplatform.com/MSMI/OSPSystemStructure"
_N = {"o": OSP}
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


def read_osp(root: Element, file: Path, notes: list[str]) -> SspStructure:
    """The structure that it describes; ``notes`` gets what is worth telling.

    Raises:
        InputError: it uses what cannot be used here, with its place.
    """
    system = SspSystem("root", {}, [])
    step = root.findtext("o:BaseStepSize", None, _N)
    algorithm = root.findtext("o:Algorithm", "fixedStep", _N)
    if algorithm != "fixedStep":
        notes.append(f"the algorithm {algorithm} is not known here: steps have a fixed length")
    for each in root.findall("o:Simulators/o:Simulator", _N):
        name = each.get("name", "")
        if name in system.elements:
            raise InputError(f"there are two simulators '{name}'.", place(file, each))
        if not name or not each.get("source"):
            raise InputError("a simulator has a name and a source.", place(file, each))
        source = file.parent / unquote(each.get("source", "").removeprefix("file:"))
        system.elements[name] = SspComponent(
            name=name,
            source=source,
            kinds=_causalities(source),
            bindings=[_initial_values(each, file, notes)],
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


def _initial_values(simulator: Element, file: Path, notes: list[str]) -> ParameterBinding:
    values: dict[str, GivenValue] = {}
    for each in simulator.findall("o:InitialValues/o:InitialValue", _N):
        name = each.get("variable", "")
        if len(each) != 1:
            raise InputError(f"the initial value of '{name}' is not one.", place(file, each))
        if name in values:
            notes.append(f"{place(file, each)}: {name} is given twice; the last value counts")
        values[name] = GivenValue(_value(each[0], file), None)
    return ParameterBinding(values, ())


def _value(element: Element, file: Path) -> Any:
    kind, text = local(element), element.get("value", "")
    try:
        if kind == "Real":
            return number(element, "value", "", file)
        if kind == "Integer":
            return int(text)
        if kind == "Boolean":
            return _TRUTHS[text]
    except (InputError, ValueError, KeyError):
        raise InputError(f"'{text}' is no {kind}.", place(file, element)) from None
    if kind == "String":
        return text
    raise InputError(f"an initial value of type {kind} cannot be given.", place(file, element))


def _connections(element: Element, system: SspSystem, file: Path) -> Iterator[SspConnection]:
    kind = local(element)
    if len(element) != 2:
        raise InputError(f"a {kind} has two ends, not {len(element)}.", place(file, element))
    if kind == "VariableConnection":
        yield _plain(element, *(_end(each) for each in element))
    elif kind == "VariableGroupConnection":
        groups = [_group(each, system, file) for each in element]
        if len(groups[0]) != len(groups[1]):
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
        if variable is None or signal is None:
            raise InputError("it does not join a variable to a signal.", place(file, each))
        name, end = signal.get("function", ""), signal.get("name", "")
        function = functions.get(name)
        if function is None:
            raise InputError(
                f"there is no function '{name}'.{did_you_mean(name, functions)}", place(file, each)
            )
        if local(function) != "LinearTransformation":
            raise InputError(
                f"a {local(function)} '{name}' cannot be used here.", place(file, each)
            )
        if end not in {"in", "out"}:
            raise InputError(
                f"the function '{name}' has no signal '{end}': there are in and out.",
                place(file, each),
            )
        if end == "in" and into.setdefault(name, _end(variable)) != _end(variable):
            raise InputError(f"the function '{name}' is driven twice.", place(file, each))
        if end == "out":
            out.append((name, _end(variable), each))
    for name in into.keys() ^ {name for name, *_ in out}:
        missing = "nothing takes what it gives" if name in into else "nothing drives it"
        raise InputError(f"the function '{name}': {missing}.", place(file, functions[name]))
    for name, target, element in out:
        factor = number(functions[name], "factor", "1", file)
        offset = number(functions[name], "offset", "0", file)
        yield SspConnection(into[name], target, factor, offset, True, {}, element)
