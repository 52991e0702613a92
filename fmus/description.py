"""What both modelDescription.xml writers share: XML text, units and dependencies."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

from cosim.base.quantities.units import BASES, parse_unit
from fmus.layout import Placed, SlotElement, SlotLayout, elements_of

LOG_CATEGORIES = {
    "logInfo": "What a model says for information",
    "logStatusWarning": "Warnings",
    "logStatusDiscard": "Why a step was discarded",
    "logStatusError": "Errors",
    "logStatusFatal": "Errors after which the instance can only be freed",
    "logAll": "All of the above",
}

TOOL = "cohaptic"
"""The generationTool; outputs of FMUs made by it may be read after setting inputs in one tick."""

MEANING = "org.cohaptic.meaning"
"""Type of the annotation that says what a variable means; in FMI 2.0 the name of a ``Tool``."""

ROLE = "org.cohaptic.role"
"""Type of the annotation that says what becomes of a variable where a device takes its place."""


def to_text(root: ET.Element) -> bytes:
    """The document as indented UTF-8, the same bytes for the same content."""
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def add(parent: ET.Element, tag: str, **attributes: str | None) -> ET.Element:
    """Append an element; attributes that are ``None`` are left out."""
    given = {name: value for name, value in attributes.items() if value is not None}
    return ET.SubElement(parent, tag, given)


def add_units(parent: ET.Element, layout: SlotLayout) -> None:
    """``UnitDefinitions`` with the exponents of the base units."""
    if not layout.units:
        return
    definitions = add(parent, "UnitDefinitions")
    for unit in layout.units:
        exponents = {base: str(power) for base, power in base_exponents(unit).items()}
        add(add(definitions, "Unit", name=unit), "BaseUnit", **exponents)


def base_exponents(text: str) -> dict[str, int]:
    """The exponents of the SI base units (and ``rad``), zeros left out.

    Raises:
        ValueError: the unit is not known, or has a factor or an offset: models compute in SI units.
    """
    unit = parse_unit(text)
    if unit.exponents is None or not unit.is_coherent:
        raise ValueError(f"'{text}' is not a coherent SI unit, in which models compute.")
    return {base: power for base, power in zip(BASES, unit.exponents, strict=True) if power}


def add_log_categories(parent: ET.Element) -> None:
    """``LogCategories``, the ones that the glue knows."""
    categories = add(parent, "LogCategories")
    for name, description in LOG_CATEGORIES.items():
        add(categories, "Category", name=name, description=description)


def add_meanings(
    parent: ET.Element, elements: list[SlotElement], *, variable: str | None = None
) -> None:
    """``Meaning`` for each element that has one; ``element`` numbers those of an array from 1.

    All of it stands in attributes: checkers of descriptions refuse text in an annotation.
    """
    for element in elements:
        if element.meaning is not None:
            slot = element.belongs_to
            add(
                parent,
                "Meaning",
                name=element.meaning.value,
                variable=variable,
                element=str(element.index + 1) if len(elements) > 1 else None,
                peer=None if slot.peer is None else str(slot.peer),
                finger=None if slot.finger is None else str(slot.finger),
            )


def feedthrough(layout: SlotLayout, placed: Placed) -> list[Placed]:
    """The inputs that an output depends on within a tick."""
    return list(layout.matching(placed.variable.depends_on, placed.group))


def initial_dependencies(layout: SlotLayout, placed: Placed) -> list[Placed]:
    """What an output or calculated parameter depends on in initialisation mode.

    The inputs it depends on directly, those that prime it, and every parameter: which of them
    matter is nowhere written down, and a list that is too long is safe.
    """
    patterns = placed.variable.depends_on + placed.variable.initial_depends_on
    inputs = layout.matching(patterns, placed.group)
    parameters = (other for other in layout.placed if other.variable.causality == "parameter")
    return sorted((*inputs, *parameters), key=lambda other: other.slot)


def is_unknown_at_start(placed: Placed) -> bool:
    """Whether the variable belongs into ``InitialUnknowns``."""
    return placed.variable.causality in {"output", "calculatedParameter"}


def scalars(places: Iterable[Placed]) -> list[SlotElement]:
    """All elements of some variables, one by one."""
    return [element for placed in places for element in elements_of(placed)]


def number_text(value: float | int | bool | str | None) -> str:
    """A value as XML schema writes it; ``repr`` gives a double back bit for bit."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value) if isinstance(value, str) else repr(value)


def start_text(element: SlotElement) -> str | None:
    """The start value of an element, ``None`` where it has none."""
    variable, start = element.variable, element.start
    if variable.causality not in {"parameter", "input"}:
        return None
    if variable.type == "string":
        return str(start or "")
    if variable.type == "boolean":
        return number_text(bool(start))
    if variable.type == "real":
        return number_text(float(start or 0.0))
    return number_text(int(start or 0))


def limit_text(element: SlotElement, limit: float | None) -> str | None:
    """A minimum or maximum in the variable's own type."""
    if limit is None:
        return None
    return number_text(float(limit) if element.variable.type == "real" else int(limit))
