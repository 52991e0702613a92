"""A scenario as an SSP 2.0 package that holds all of its FMUs.

What SSP has no word for (rates, stations, channels, what is recorded and expected) stands in
annotations of our own type, so that reading it back gives the same run. The whole resolved scenario
lies in ``extra`` for people and other tools.
"""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from cosim.base.component import Causality, Variable, VariableType
from cosim.base.document.xml_text import xml_text
from cosim.base.document.yaml_writer import write_yaml
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning
from cosim.base.quantities.units import BASES
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.connecting.matching import match_elements
from cosim.master.components.participant import Participant
from cosim.scenario import Connection, Kind
from cosim.scenario.resolved import to_document
from cosim.ssp.documents import NAMESPACES, OWN, OWN_TYPE, SSC, SSD, SSV, Element, refuse_invalid
from cosim.ssp.package import ROOT
from fmus.archive import zip_bytes

EXTRA = "extra/org.cohaptic/scenario.yaml"
_SHOWN = {
    Causality.INPUT: "input",
    Causality.OUTPUT: "output",
    Causality.PARAMETER: "parameter",
    Causality.STRUCTURAL_PARAMETER: "structuralParameter",
}
_FMI2 = {VariableType.FLOAT64: "Real", VariableType.INT32: "Integer"}


def to_ssp(assembly: Assembly) -> bytes:
    """The package, the same bytes for the same scenario.

    Raises:
        InputError: a component is neither an FMU nor a class that is found wherever it is read.
    """
    for name, part in assembly.scenario.components.items():
        if part.kind is Kind.PYTHON and not _is_installed(part.source):
            raise InputError(
                f"{name} cannot be exported: its class ({part.source}) lies in no installed "
                "package."
            )
        if part.kind not in {Kind.FMU, Kind.PYTHON}:
            raise InputError(f"{name} cannot be exported: an SSP holds FMUs, and names classes.")
    return _Exporter(assembly).package()


class _Exporter:
    def __init__(self, assembly: Assembly) -> None:
        self._assembly, self._scenario = assembly, assembly.scenario
        self._written = to_document(assembly.scenario)
        self._python = {
            name: self._written["components"][name]
            for name, part in self._scenario.components.items()
            if part.kind is Kind.PYTHON
        }
        self._files: dict[str, bytes] = {}
        self._sources: dict[str, str] = {}
        make: Any = importlib.import_module("lxml.builder").ElementMaker
        self._d: Any = make(namespace=SSD, nsmap={k: NAMESPACES[k] for k in NAMESPACES})
        self._c: Any = make(namespace=SSC)
        self._v: Any = make(namespace=SSV)
        self._own: Any = make(namespace=OWN)

    def package(self) -> bytes:
        etree: Any = importlib.import_module("lxml.etree")
        root = self._root()
        refuse_invalid(root)
        text: bytes = etree.tostring(
            root, xml_declaration=True, encoding="UTF-8", pretty_print=True
        )
        resolved = dict(self._written)
        resolved["components"] = {
            name: part if name in self._python else {**part, "fmu": f"../../{self._sources[name]}"}
            for name, part in self._written["components"].items()
        }
        for part in resolved["components"].values():
            part.pop("flavour", None)
        return zip_bytes({ROOT: text, **self._files, EXTRA: write_yaml(resolved).encode()})

    def _root(self) -> Element:
        d = self._d
        scenario = self._scenario
        participants = self._assembly.participants
        elements = [
            self._component(name, each)
            for name, each in participants.items()
            if each.fmu is not None
        ]
        about: list[str] = []
        connections: list[Element] = []
        for connection, written in zip(
            scenario.connections, self._written["connections"], strict=True
        ):
            ends = {connection.source.component, connection.target.component}
            if ends & {*scenario.channels, *self._python} or self._is_about_ticks(connection):
                about.append(written)
            else:
                connections += self._connections(connection, written)
        rest = {
            key: value
            for key, value in self._written.items()
            if key not in {"cohaptic", "components", "connections", "title"}
            and (value or key == "record")
        }
        name = scenario.title or scenario.name
        if name != xml_text(name):
            rest["title"] = scenario.title
        more = {"components": self._python, "connections": about}
        own = self._own.Scenario(write_yaml(rest | {k: v for k, v in more.items() if v}))
        system = d.System(name=scenario.name)
        system.append(d.Elements(*elements))
        if connections:
            system.append(d.Connections(*connections))
        system.append(d.Annotations(self._annotation(own)))
        root = d.SystemStructureDescription(
            system,
            version="2.0",
            name=xml_text(name),
            generationTool="cohaptic",
        )
        if units := self._units():
            root.append(d.Units(*units))
        begin, end = scenario.start_time, scenario.start_time + scenario.duration
        root.append(d.DefaultExperiment(startTime=repr(float(begin)), stopTime=repr(float(end))))
        return root

    def _component(self, name: str, participant: Participant) -> Element:
        fmu = participant.fmu
        assert fmu is not None, "others were refused"
        d = self._d
        stem = fmu.path.name.removesuffix(".fmu")
        source = f"resources/{stem}.fmu"
        content = fmu.path.read_bytes()
        if self._files.setdefault(source, content) != content:
            source = f"resources/{stem}-{fmu.sha256[:8]}.fmu"
            self._files[source] = content
        self._sources[name] = source
        element = d.Component(name=name, source=source, implementation="CoSimulation")
        events = participant.interface.events
        triggered = frozenset[str]() if events is None else events.triggered()
        counts = frozenset[str]() if events is None else events.clock_names() - triggered
        connectors = [
            self._clock(variable)
            if variable.name in triggered
            else self._connector(variable, fmu.version)
            for variable in participant.interface.variables.values()
            if variable.causality in _SHOWN and variable.name not in counts
        ]
        if connectors:
            element.append(d.Connectors(*connectors))
        if values := [*self._values(participant)]:
            inner = self._v.ParameterSet(
                self._v.Parameters(*values), version="2.0", name=f"{name}_values"
            )
            element.append(d.ParameterBindings(d.ParameterBinding(d.ParameterValues(inner))))
        own = {
            key: value
            for key, value in self._written["components"][name].items()
            if key not in {"fmu", "flavour", "parameters", "start"}
        }
        annotation = self._own.Component(**{key: _text(value) for key, value in own.items()})
        element.append(d.Annotations(self._annotation(annotation)))
        return element

    def _clock(self, variable: Variable) -> Element:
        inner = self._c.Clock(intervalVariability="triggered")
        return self._d.Connector(inner, name=variable.name, kind=_SHOWN[variable.causality])

    def _connector(self, variable: Variable, version: int) -> Element:
        kind = variable.type
        attributes = {"unit": variable.unit} if kind.is_float and variable.unit else {}
        if kind is VariableType.ENUMERATION:
            inner = self._c.Integer() if version == 2 else self._c.Int64()
        else:
            name = _FMI2.get(kind, kind.value) if version == 2 else kind.value
            inner = self._c(name, **attributes)
        connector = self._d.Connector(inner, name=variable.name, kind=_SHOWN[variable.causality])
        for size in variable.shape:
            connector.append(self._c.Dimension(size=str(size)))
        return connector

    def _values(self, participant: Participant) -> Iterator[Element]:
        for name, elements in {**participant.parameters, **participant.start}.items():
            variable = participant.interface.variables[name]
            kind = variable.type
            if kind is VariableType.STRING:
                is_file = variable.meaning is Meaning.FILE
                texts = [self._resource(Path(e)) if is_file and e else str(e) for e in elements]
                if any(text != xml_text(text) for text in texts):
                    raise InputError(
                        f"{participant.name}.{name} cannot be exported: it has characters that "
                        "XML cannot carry."
                    )
                inner = self._texts(self._v.String, texts)
            elif kind is VariableType.BINARY:
                inner = self._texts(self._v.Binary, [element.hex() for element in elements])
            elif kind is VariableType.BOOLEAN:
                inner = self._v.Boolean(value=" ".join(_text(bool(e)) for e in elements))
            elif kind.is_float:
                inner = self._v.Float64(value=" ".join(repr(float(e)) for e in elements))
            else:
                inner = self._v.Int64(value=" ".join(str(int(e)) for e in elements))
            yield self._v.Parameter(inner, name=name)

    def _texts(self, make: Any, texts: list[str]) -> Element:
        """One text as an attribute, several as elements of their own."""
        if len(texts) == 1:
            return make(value=texts[0])
        return make(*(self._v.Value(value=text) for text in texts))

    def _resource(self, file: Path) -> str:
        name = f"resources/{file.name}"
        content = file.read_bytes()
        if self._files.setdefault(name, content) != content:
            raise InputError(f"two files of the name {file.name} differ; rename one of them.")
        return name

    def _connections(
        self, connection: Connection, written: str | dict[str, Any]
    ) -> Iterator[Element]:
        interfaces = {
            end: self._assembly.participants[reference.component].interface
            for end, reference in (("start", connection.source), ("end", connection.target))
        }
        source, target = interfaces["start"], interfaces["end"]
        origin = source.select(connection.source.path)
        selected = target.select(connection.target.path)
        own = self._own_of(written)
        for there, here in match_elements(connection, source, origin, target, selected):
            attributes = {
                "startElement": source.component,
                "endElement": target.component,
            }
            for end, interface, element in (("start", source, there), ("end", target, here)):
                name, _, index = interface.element_name(element).partition("[")
                if interface.variables[element.variable].shape:
                    attributes[f"{end}Connector"] = name
                    attributes[f"{end}Indices"] = index.rstrip("]").replace(",", " ")
                else:
                    attributes[f"{end}Connector"] = element.variable
            if connection.ignores_unit:
                attributes["suppressUnitConversion"] = "true"
            found = self._d.Connection(**attributes)
            if (connection.factor, connection.offset) != (1.0, 0.0):
                factor, offset = repr(connection.factor), repr(connection.offset)
                found.append(self._c.LinearTransformation(factor=factor, offset=offset))
            if own:
                found.append(self._d.Annotations(self._annotation(self._own.Connection(**own))))
            yield found

    def _is_about_ticks(self, connection: Connection) -> bool:
        """Whether a clock meets anything but a clock, as it can only where ticks are counted."""
        has_clock, all_triggered = False, True
        for end in (connection.source, connection.target):
            interface = self._assembly.participants[end.component].interface
            events = interface.events
            clocks = frozenset[str]() if events is None else events.clock_names()
            triggered = frozenset[str]() if events is None else events.triggered()
            names = {each.variable for each in interface.select(end.path).members.values()}
            has_clock = has_clock or bool(names & clocks)
            all_triggered = all_triggered and names <= triggered
        return has_clock and not all_triggered

    def _own_of(self, written: str | dict[str, Any]) -> dict[str, str]:
        """What a connection has besides its ends and its transformation."""
        if isinstance(written, str):
            via = written.partition(" via ")[2]
            return {"via": via} if via else {}
        known = {"from", "to", "factor", "offset", "unit"}
        return {key: _text(value) for key, value in written.items() if key not in known}

    def _units(self) -> list[Element]:
        found: dict[str, Element] = {}
        fmus = (each for each in self._assembly.participants.values() if each.fmu is not None)
        for participant in fmus:
            interface = participant.interface
            for name, variable in interface.variables.items():
                unit = interface.unit(name)
                if not variable.unit or unit is None or unit.exponents is None:
                    continue
                if variable.causality not in _SHOWN or not variable.type.is_float:
                    continue
                powers = zip(BASES, unit.exponents, strict=True)
                base = {power: str(exponent) for power, exponent in powers if exponent}
                if unit.factor != 1:
                    base["factor"] = repr(float(unit.factor))
                if unit.offset:
                    base["offset"] = repr(float(unit.offset))
                found.setdefault(
                    variable.unit, self._c.Unit(self._c.BaseUnit(**base), name=variable.unit)
                )
        return [found[name] for name in sorted(found)]

    def _annotation(self, content: Element) -> Element:
        return self._c.Annotation(content, type=OWN_TYPE)


def _is_installed(source: str) -> bool:
    """Whether a class is found by its name wherever this package's environment is."""
    module = source.partition(":")[0]
    try:
        found = None if "/" in module else importlib.util.find_spec(module)
    except (ImportError, ValueError):
        return False
    return found is not None


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return repr(value) if isinstance(value, float) else str(value)
