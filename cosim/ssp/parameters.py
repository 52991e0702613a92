"""Parameter bindings: sets of values, inline or in files, perhaps mapped to other names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import exact
from cosim.base.quantities.units import BASES, Unit, unit_of
from cosim.ssp.documents import NAMESPACES, Element, local, place, read_valid, transformation

SET_TYPE = "application/x-ssp-parameter-set"
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


@dataclass(frozen=True, slots=True)
class GivenValue:
    """A value of a parameter set: a number, a boolean, a text, or a list of such."""

    value: Any
    unit: Unit | None

    def moved(self, factor: float, offset: float) -> GivenValue:
        """The same behind a linear transformation."""
        if (factor, offset) == (1.0, 0.0):
            return self
        return GivenValue(_each(self.value, lambda each: factor * each + offset), self.unit)


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
        values = _values(inline, file)
    elif source := element.get("source"):
        values = _from_file(_path(element, source, own, file), notes)
    mapping = element.find("ssd:ParameterMapping", NAMESPACES)
    if mapping is not None:
        entries, at = mapping.find("ssm:ParameterMapping", NAMESPACES), file
        if entries is None:
            at = _path(mapping, mapping.get("source", ""), own, file)
            entries, found = read_valid(at)
            notes += found
        values = _mapped(values, entries, at)
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
    return _values(root, path)


def _values(root: Element, file: Path) -> dict[str, GivenValue]:
    units = read_units(root.find("ssv:Units", NAMESPACES))
    found: dict[str, GivenValue] = {}
    for parameter in root.findall("ssv:Parameters/ssv:Parameter", NAMESPACES):
        for child in parameter:
            if local(child) in {"Annotations", "Dimension"}:
                continue
            found[parameter.get("name", "")] = _value(child, units, file)
    return found


def _value(element: Element, units: Mapping[str, Unit], file: Path) -> GivenValue:
    kind = local(element)
    text = element.get("value")
    if kind in {"String", "Enumeration"}:
        several = [each.get("value") for each in element if local(each) == "Value"]
        return GivenValue(several or text, None)
    if kind == "Binary" and text is not None:
        return GivenValue(f"hex:{text}", None)
    if text is None:
        raise InputError(f"a value of type {kind} cannot be given here.", place(file, element))
    unit = element.get("unit")
    read = {"Real": float, "Float64": float, "Float32": float, "Boolean": _truth}.get(kind, int)
    try:
        values = [read(word) for word in text.split()]
    except (ValueError, KeyError):
        raise InputError(f"'{text}' is no {kind}.", place(file, element)) from None
    return GivenValue(
        values[0] if len(values) == 1 else values,
        None if unit is None else units.get(unit) or unit_of(unit),
    )


def _truth(word: str) -> bool:
    return _TRUTHS[word]


def _mapped(
    values: Mapping[str, GivenValue], entries: Element, file: Path
) -> dict[str, GivenValue]:
    found: dict[str, GivenValue] = {}
    for entry in entries.findall("ssm:MappingEntry", NAMESPACES):
        given = values.get(entry.get("source", ""))
        if given is not None:
            found[entry.get("target", "")] = given.moved(*transformation(entry, file))
    return found


def read_units(element: Element) -> dict[str, Unit]:
    """The units that a file defines, by name."""
    if element is None:
        return {}
    found: dict[str, Unit] = {}
    for unit in element.findall("ssc:Unit", NAMESPACES):
        base = unit.find("ssc:BaseUnit", NAMESPACES)
        name = unit.get("name", "")
        if base is not None:
            found[name] = Unit(
                name,
                tuple(int(base.get(power, "0")) for power in BASES),
                exact(float(base.get("factor", "1"))),
                exact(float(base.get("offset", "0"))),
            )
    return found


def in_unit(given: GivenValue, unit: Unit | None) -> Any:
    """The value in a variable's unit.

    Raises:
        ValueError: the two measure different things.
    """
    if given.unit is None or unit is None or given.unit == unit:
        return given.value
    if given.unit.exponents is None or unit.exponents is None:
        return given.value  # one of them is only a name, which says nothing
    if given.unit.exponents != unit.exponents:
        raise ValueError(f"it is in {given.unit.name}, which does not convert to {unit.name}")
    source = given.unit

    def converted(value: float) -> float:
        base: Fraction = exact(value) * source.factor + source.offset
        return float((base - unit.offset) / unit.factor)

    return _each(given.value, converted)


def _each(value: Any, change: Callable[[Any], Any]) -> Any:
    """The changed value, or the list of changed values."""
    if isinstance(value, list):
        return [change(each) for each in cast("list[Any]", value)]
    return change(value)
