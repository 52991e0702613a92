"""``modelDescription.xml`` of FMI 2.0: one scalar variable per element, in slot order."""

from __future__ import annotations

import xml.etree.ElementTree as ET

from fmus import description
from fmus.description import add
from fmus.layout import Placed, SlotElement, SlotLayout
from fmus.table import Model

_TAG = {
    "real": "Real",
    "integer": "Integer",
    "boolean": "Boolean",
    "enumeration": "Enumeration",
    "string": "String",
}


def model_description(model: Model, *, token: str) -> bytes:
    """The document; the index of a variable is its place in the list of elements, from 1.

    The variable ``time`` is left out: FMI 2.0 does not need it.
    """
    layout = SlotLayout(model)
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=model.name,
        guid=token,
        description=model.description,
        version=model.version,
        generationTool=description.TOOL,
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    add(
        root,
        "CoSimulation",
        modelIdentifier=model.name,
        canHandleVariableCommunicationStepSize="true" if model.variable_step else "false",
        canGetAndSetFMUstate="true",
        canSerializeFMUstate="true",
        canNotUseMemoryManagementFunctions="true",
    )
    description.add_units(root, layout)
    _add_types(root, layout)
    description.add_log_categories(root)
    add(root, "DefaultExperiment", startTime="0.0", stepSize=repr(model.default_step))
    variables = add(root, "ModelVariables")
    for element in layout.elements:
        _add_variable(variables, element)
    _add_structure(root, layout)
    return description.to_text(root)


def _add_types(root: ET.Element, layout: SlotLayout) -> None:
    if not layout.enumerations:
        return
    definitions = add(root, "TypeDefinitions")
    for enumeration in layout.enumerations:
        simple = add(
            definitions,
            "SimpleType",
            name=enumeration.name,
            description=enumeration.description,
        )
        kind = add(simple, "Enumeration")
        for item in enumeration.items:
            add(kind, "Item", name=item.name, value=str(item.value), description=item.description)


def _add_variable(variables: ET.Element, element: SlotElement) -> None:
    variable = element.variable
    scalar = add(
        variables,
        "ScalarVariable",
        name=element.name,
        valueReference=str(element.slot),
        description=variable.description,
        causality=variable.causality,
        variability=variable.variability,
        initial="calculated" if variable.causality not in {"parameter", "input"} else None,
    )
    limited = variable.type in {"real", "integer"}
    add(
        scalar,
        _TAG[variable.type],
        declaredType=variable.enumeration.name if variable.enumeration else None,
        unit=variable.unit or None,
        min=description.limit_text(element, variable.minimum) if limited else None,
        max=description.limit_text(element, variable.maximum) if limited else None,
        start=description.start_text(element),
    )
    if variable.role is None and element.meaning is None:
        return
    annotations = add(scalar, "Annotations")
    if variable.role is not None:
        add(add(annotations, "Tool", name=description.ROLE), "Role", name=variable.role)
    if element.meaning is not None:
        description.add_meanings(add(annotations, "Tool", name=description.MEANING), [element])


def _add_structure(root: ET.Element, layout: SlotLayout) -> None:
    index = {element.slot: str(number) for number, element in enumerate(layout.elements, start=1)}

    def unknown(parent: ET.Element, element: SlotElement, known: list[Placed]) -> None:
        dependencies = " ".join(index[other.slot] for other in description.scalars(known))
        add(parent, "Unknown", index=index[element.slot], dependencies=dependencies)

    structure = add(root, "ModelStructure")
    outputs = [placed for placed in layout.placed if placed.variable.causality == "output"]
    if outputs:
        parent = add(structure, "Outputs")
        for placed in outputs:
            for element in description.scalars([placed]):
                unknown(parent, element, description.feedthrough(layout, placed))
    initial = [placed for placed in layout.placed if description.is_unknown_at_start(placed)]
    if initial:
        parent = add(structure, "InitialUnknowns")
        for placed in initial:
            for element in description.scalars([placed]):
                unknown(parent, element, description.initial_dependencies(layout, placed))
