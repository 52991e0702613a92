"""XML of SSP: its namespaces, and files that are read and judged by the standard's schemas."""

from __future__ import annotations

import importlib
import math
from functools import cache
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError, Location

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
SSM = "http://ssp-standard.org/SSP1/SystemStructureParameterMapping"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
OWN = "https://cohaptic.org/ssp"
"""Of what stands in our annotations."""
OWN_TYPE = "org.cohaptic"
OSP_TYPES = frozenset({"com.opensimulationplatform", "com.opensimulationplatform.ssp"})
NAMESPACES = {"ssd": SSD, "ssv": SSV, "ssm": SSM, "ssc": SSC, "cohaptic": OWN}
_SCHEMAS = {
    SSD: "SystemStructureDescription.xsd",
    SSV: "SystemStructureParameterValues.xsd",
    SSM: "SystemStructureParameterMapping.xsd",
}

Element = Any
"""An element of lxml, which has no types."""


def read_xml(file: Path) -> Element:
    """The root of an XML file; entities and networks are not followed.

    Raises:
        InputError: it cannot be read.
    """
    etree: Any = importlib.import_module("lxml.etree")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, remove_comments=True)
    try:
        return etree.parse(str(file), parser).getroot()
    except OSError:
        raise InputError(f"{file} cannot be read.") from None
    except etree.XMLSyntaxError as error:
        line, column = error.position
        raise InputError(f"{error.msg}.", Location(str(file), line, column)) from None


def read_valid(file: Path) -> tuple[Element, list[str]]:
    """The root of a file of SSP, and what the standard's schema finds wrong with it.

    Raises:
        InputError: it cannot be read, or is none of SSP's files.
    """
    root = read_xml(file)
    namespace = namespace_of(root)
    if namespace not in _SCHEMAS:
        raise InputError(f"{file} is no file of SSP: its root is {root.tag}.")
    schema = _schema(namespace)
    if schema.validate(root):
        return root, []
    return root, [f"{file.name}:{each.line}: {each.message}" for each in schema.error_log]


def refuse_invalid(root: Element) -> None:
    """Refuse what is about to be written where the schema does.

    Raises:
        ValueError: it is not valid.
    """
    schema = _schema(namespace_of(root))
    if not schema.validate(root):
        raise ValueError(str(schema.error_log))


def namespace_of(element: Element) -> str:
    """The namespace of an element's name."""
    tag = str(element.tag)
    return tag[1:].partition("}")[0] if tag.startswith("{") else ""


def local(element: Element) -> str:
    """An element's name without its namespace."""
    return str(element.tag).rpartition("}")[2]


def place(file: Path, element: Element) -> Location:
    """Where an element begins."""
    return Location(str(file), int(element.sourceline or 0), 1)


def transformation(element: Element, file: Path) -> tuple[float, float]:
    """Factor and offset of a connection or a mapping entry.

    Raises:
        InputError: it maps values one by one, or is written with what is no number.
    """
    for child in element:
        if local(child) == "LinearTransformation":
            return number(child, "factor", "1", file), number(child, "offset", "0", file)
        if local(child).endswith("MappingTransformation"):
            entries = [(e.get("source"), e.get("target")) for e in child]
            if any(source != target for source, target in entries):
                raise InputError(f"a {local(child)} cannot be used here.", place(file, child))
    return 1.0, 0.0


def number(element: Element, name: str, otherwise: str, file: Path) -> float:
    """An attribute that is a number.

    Raises:
        InputError: it is none, or none that can be computed with.
    """
    text: str = element.get(name, otherwise)
    try:
        found = float(text)
    except ValueError:
        found = math.nan
    if not math.isfinite(found):
        raise InputError(f"the {name} '{text}' is no number.", place(file, element))
    return found


@cache
def _schema(namespace: str) -> Any:
    etree: Any = importlib.import_module("lxml.etree")
    return etree.XMLSchema(etree.parse(str(Path(__file__).parent / "schema" / _SCHEMAS[namespace])))
