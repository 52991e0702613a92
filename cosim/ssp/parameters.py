"""Parameter bindings: sets of values, inline or in files, perhaps mapped to other names."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import exact
from cosim.base.quantities.units import BASES, Unit, unit_of
from cosim.ssp.conversions import UNCHANGED, Linear, between
from cosim.ssp.documents import (
    NAMESPACES,
    Element,
    local,
    number,
    place,
    read_valid,
    transformation,
)

SET_TYPE = "application/x-ssp-parameter-set"
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


@dataclass(frozen=True, slots=True)
class GivenValue:
    """A value of a parameter set: a number, a boolean, a text, or a list of such."""

    value: Any
    unit: Unit | None
    mapped: Linear = UNCHANGED
    """What a mapping does with it, once it is in the unit of where it goes."""

    def arriving(self, unit: Unit | None) -> GivenValue:
        """In the unit of a connector or a variable, and mapped.

        Raises:
            ValueError: the two measure different things.
        """
        linear = between(self.unit, unit).then(self.mapped)
        return GivenValue(_moved(self.value, linear), self.unit if unit is None else unit)

    def through(self, linear: Linear) -> GivenValue:
        """Behind the linear transformation of a connection."""
        return GivenValue(_moved(self.value, linear), self.unit)


@dataclass(frozen=True, slots=True)
class ParameterBinding:
    """The values that one binding gives, by name within the element that it belongs to."""

    values: Mapping[str, GivenValue]
    notes: tuple[str, ...]


def read_bindings(element: Element, own: Path, file: Path) -> list[ParameterBinding]:
    """The bindings of a system or component; ``own`` is what ``sourceBase="component"`` means.

    Raises:
        InputError: a set or a mapping cannot be read, or is of an unknown type.
    """
    return [
        _binding(each, own, file)
        for each in element.findall("ssd:ParameterBindings/ssd:ParameterBinding", NAMESPACES)
    ]


def _binding(element: Element, own: Path, file: Path) -> ParameterBinding:
    kind = element.get("type", SET_TYPE)
    if kind != SET_TYPE:
        raise InputError(f"a parameter set of type {kind} cannot be read.", place(file, element))
    notes: list[str] = []
    values: dict[str, GivenValue] = {}
    inline = element.find("ssd:ParameterValues/ssv:ParameterSet", NAMESPACES)
    if inline is not None:
        values = _values(inline, file, notes)
    elif source := element.get("source"):
        values = _from_file(_path(element, source, own, file), notes)
    mapping = element.find("ssd:ParameterMapping", NAMESPACES)
    if mapping is not None:
        entries, at = mapping.find("ssm:ParameterMapping", NAMESPACES), file
        if entries is None:
            at = _path(mapping, mapping.get("source", ""), own, file)
            entries, found = read_valid(at)
            notes += found
        values = _mapped(values, entries, at, notes)
    prefix = element.get("prefix", "")
    return ParameterBinding({prefix + name: each for name, each in values.items()}, tuple(notes))


def _path(element: Element, source: str, own: Path, file: Path) -> Path:
    is_own = element.get("sourceBase") == "component"
    path = (own.parent if is_own else file.parent) / unquote(source.removeprefix("file:"))
    if not path.is_file():
        raise InputError(f"there is no {source}.", place(file, element))
    return path


def _from_file(path: Path, notes: list[str]) -> dict[str, GivenValue]:
    root, found = read_valid(path)
    notes += found
    return _values(root, path, notes)


def _values(root: Element, file: Path, notes: list[str]) -> dict[str, GivenValue]:
    units = read_units(root.find("ssv:Units", NAMESPACES), file)
    found: dict[str, GivenValue] = {}
    for parameter in root.findall("ssv:Parameters/ssv:Parameter", NAMESPACES):
        for child in parameter:
            if local(child) in {"Annotations", "Dimension"}:
                continue
            name = parameter.get("name", "")
            if name in found:
                notes.append(f"{place(file, child)}: {name} is given twice; the last value counts")
            found[name] = _value(child, units, file)
    return found


def _value(element: Element, units: Mapping[str, Unit], file: Path) -> GivenValue:
    kind = local(element)
    text = element.get("value")
    if kind in {"String", "Enumeration", "Binary"}:
        several = [each.get("value", "") for each in element if local(each) == "Value"]
        spelling = "hex:" if kind == "Binary" else ""
        texts = [spelling + each for each in (several or [text or ""])]
        return GivenValue(texts if several else texts[0], None)
    if text is None:
        raise InputError(f"a value of type {kind} cannot be given here.", place(file, element))
    unit = element.get("unit")
    read = {"Real": float, "Float64": float, "Float32": float, "Boolean": _truth}.get(kind, int)
    try:
        values = [read(word) for word in text.split()]
    except (ValueError, KeyError):
        values = []
    if not values or not all(map(math.isfinite, values)):
        raise InputError(f"'{text}' is no {kind}.", place(file, element))
    return GivenValue(
        values[0] if len(values) == 1 else values,
        None if unit is None else units.get(unit) or unit_of(unit),
    )


def _truth(word: str) -> bool:
    return _TRUTHS[word]


def _mapped(
    values: Mapping[str, GivenValue], entries: Element, file: Path, notes: list[str]
) -> dict[str, GivenValue]:
    found: dict[str, GivenValue] = {}
    for entry in entries.findall("ssm:MappingEntry", NAMESPACES):
        source = entry.get("source", "")
        given = values.get(source)
        if given is None:
            notes.append(f"{place(file, entry)}: no parameter '{source}' is given to be mapped")
        else:
            is_free = entry.get("suppressUnitConversion") in {"true", "1"}
            found[entry.get("target", "")] = GivenValue(
                given.value,
                None if is_free else given.unit,
                Linear.of(*transformation(entry, file)),
            )
    return found


def read_units(element: Element, file: Path) -> dict[str, Unit]:
    """The units that a file defines, by name.

    Raises:
        InputError: one is written with what is no number.
    """
    if element is None:
        return {}
    found: dict[str, Unit] = {}
    for unit in element.findall("ssc:Unit", NAMESPACES):
        base = unit.find("ssc:BaseUnit", NAMESPACES)
        name = unit.get("name", "")
        if base is None:
            continue
        powers = [number(base, power, "0", file) for power in BASES]
        factor = exact(number(base, "factor", "1", file))
        if not factor or not all(power.is_integer() for power in powers):
            raise InputError(
                f"nothing converts to the unit {name}: its factor is 0, or one of its powers no "
                "whole number.",
                place(file, base),
            )
        offset = exact(number(base, "offset", "0", file))
        found[name] = Unit(name, tuple(map(int, powers)), factor, offset)
    return found


def _moved(value: Any, linear: Linear) -> Any:
    """The changed value, or the list of changed values; what is no number stays what it is."""
    if linear.changes_nothing:
        return value
    if isinstance(value, list):
        return [_moved(each, linear) for each in cast("list[Any]", value)]
    return float(exact(value) * linear.factor + linear.offset)
