"""``modelDescription.xml`` and the terminals of FMI 3.0, with scalars or with arrays."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from fmus import description
from fmus.description import add
from fmus.layout import Placed, SlotElement, SlotLayout, elements_of
from fmus.table import Model

_TAG = {
    "real": "Float64",
    "integer": "Int32",
    "boolean": "Boolean",
    "enumeration": "Enumeration",
    "string": "String",
}

TERMINALS_FILE = "terminalsAndIcons/terminalsAndIcons.xml"


def model_description(model: Model, *, token: str, arrays: bool) -> bytes:
    """The document. With ``arrays`` a variable with a size is one variable with a dimension."""
    layout = SlotLayout(model)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="3.0",
        modelName=model.name,
        instantiationToken=f"{token}-arrays" if arrays else token,
        description=model.description,
        version=model.version,
        generationTool=description.TOOL,
        variableNamingConvention="structured",
    )
    add(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canHandleVariableCommunicationStepSize="true" if model.variable_step else "false",
        canGetAndSetFMUState="true",
        canSerializeFMUState="true",
    )
    description.add_units(root, layout)
    _add_types(root, layout)
    description.add_log_categories(root)
    add(root, "DefaultExperiment", startTime="0.0", stepSize=repr(model.default_step))
    variables = add(root, "ModelVariables")
    for placed in layout.placed:
        if arrays and placed.variable.is_array:
            _add_variable(variables, placed.path, elements_of(placed), placed.variable.size)
        else:
            for element in elements_of(placed):
                _add_variable(variables, element.name, [element], None)
    add(
        variables,
        "Float64",
        name="time",
        valueReference=str(layout.slots),
        description="Simulation time",
        causality="independent",
        variability="continuous",
        unit="s" if "s" in layout.units else None,
    )
    _add_structure(root, layout, arrays=arrays)
    _add_notes_of_enumerations(root, layout)
    return description.to_text(root)


def terminals(model: Model, *, arrays: bool) -> bytes | None:
    """``terminalsAndIcons.xml``, or ``None`` for a model without terminals.

    FMI 2.0 knows no terminals; its archives carry the file all the same, for who looks for it.

    Members keep the index of an array in scalar archives: ``joint_angle[1]``.
    """
    if not model.terminals:
        return None
    layout = SlotLayout(model)
    root = ET.Element("fmiTerminalsAndIcons", fmiVersion="3.0")
    parent = add(root, "Terminals")
    for terminal in model.terminals:
        node = add(
            parent,
            "Terminal",
            name=terminal.name,
            matchingRule="plug",
            description=terminal.description,
        )
        for member, path in terminal.members.items():
            placed = layout.find(path)
            whole = arrays and placed.variable.is_array
            names = [path] if whole else [element.name for element in elements_of(placed)]
            for name in names:
                add(
                    node,
                    "TerminalMemberVariable",
                    variableName=name,
                    memberName=member + name.removeprefix(path),
                    variableKind="signal",
                )
    return description.to_text(root)


def _add_types(root: ET.Element, layout: SlotLayout) -> None:
    if not layout.enumerations:
        return
    definitions = add(root, "TypeDefinitions")
    for enumeration in layout.enumerations:
        kind = add(
            definitions,
            "EnumerationType",
            name=enumeration.name,
            description=enumeration.description,
        )
        for item in enumeration.items:
            add(kind, "Item", name=item.name, value=str(item.value), description=item.description)


def _add_variable(
    parent: ET.Element, name: str, elements: list[SlotElement], size: int | None
) -> None:
    first, variable = elements[0], elements[0].variable
    limited = variable.type in {"real", "integer"}
    starts = [text for element in elements if (text := description.start_text(element)) is not None]
    node = add(
        parent,
        _TAG[variable.type],
        name=name,
        valueReference=str(first.slot),
        description=variable.description,
        causality=variable.causality,
        variability=variable.variability,
        initial="calculated" if variable.causality not in {"parameter", "input"} else None,
        declaredType=variable.enumeration.name if variable.enumeration else None,
        unit=variable.unit or None,
        min=description.limit_text(first, variable.minimum) if limited else None,
        max=description.limit_text(first, variable.maximum) if limited else None,
        start=" ".join(starts) if starts and variable.type != "string" else None,
    )
    meanings = [element for element in elements if element.meaning is not None]
    if variable.enumeration is None and (variable.role is not None or meanings):
        annotations = add(node, "Annotations")
        if variable.role is not None:
            role = add(annotations, "Annotation", type=description.ROLE)
            add(role, "Role", name=variable.role)
        if meanings:
            description.add_meanings(
                add(annotations, "Annotation", type=description.MEANING), elements
            )
    if size is not None:
        add(node, "Dimension", start=str(size))
    if variable.type == "string":
        for text in starts:
            add(node, "Start", value=text)


def _add_notes_of_enumerations(root: ET.Element, layout: SlotLayout) -> None:
    """At the end of the whole description, each with the name of its ``variable``."""
    elements = [
        element
        for element in description.scalars(layout.placed)
        if element.variable.enumeration is not None
    ]
    meant = [element for element in elements if element.meaning is not None]
    annotations = ET.Element("Annotations")
    for element in elements:
        if element.variable.role is not None:
            role = add(annotations, "Annotation", type=description.ROLE)
            add(role, "Role", name=element.variable.role, variable=element.name)
    if meant:
        annotation = add(annotations, "Annotation", type=description.MEANING)
        for element in meant:
            description.add_meanings(annotation, [element], variable=element.name)
    if len(annotations):
        root.append(annotations)


def _add_structure(root: ET.Element, layout: SlotLayout, *, arrays: bool) -> None:
    def references(places: list[Placed]) -> list[str]:
        return [
            str(element.slot)
            for placed in places
            for element in elements_of(placed)
            if element.index == 0 or not (arrays and placed.variable.is_array)
        ]

    structure = add(root, "ModelStructure")
    for placed in layout.placed:
        if placed.variable.causality == "output":
            known = " ".join(references(description.feedthrough(layout, placed)))
            for reference in references([placed]):
                add(structure, "Output", valueReference=reference, dependencies=known)
    for placed in layout.placed:
        if description.is_unknown_at_start(placed):
            known = " ".join(references(description.initial_dependencies(layout, placed)))
            for reference in references([placed]):
                add(structure, "InitialUnknown", valueReference=reference, dependencies=known)
