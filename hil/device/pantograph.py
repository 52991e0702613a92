"""The pantograph's variable table as a device sees it: same names, sizes, units, causalities.

The table itself is ``fmus.pantograph.variables.MODEL``, written once for the FMU; a test compares
what is made of it here with the modelDescription.xml of the built FMU.
"""

from __future__ import annotations

from functools import cache

from cosim.base.component import Causality, Role, Variable, VariableType

_TYPES = {
    "real": VariableType.FLOAT64,
    "integer": VariableType.INT32,
    "boolean": VariableType.BOOLEAN,
    "enumeration": VariableType.ENUMERATION,
    "string": VariableType.STRING,
}


@cache
def terminals() -> dict[str, dict[str, str]]:
    """The pantograph FMU's terminals: terminal -> member -> variable."""
    from fmus.pantograph.variables import MODEL

    return {terminal.name: dict(terminal.members) for terminal in MODEL.terminals}


@cache
def variables() -> tuple[Variable, ...]:
    """Every variable of the pantograph FMU, for a device that takes its place."""
    from fmus.layout import SlotLayout
    from fmus.pantograph.variables import MODEL

    found: list[Variable] = []
    for placed in SlotLayout(MODEL).placed:
        entry = placed.variable
        kind = _TYPES[entry.type]
        causality = Causality(entry.causality)
        if causality is Causality.PARAMETER:
            variability = "fixed"
        else:
            variability = "continuous" if kind.is_float else "discrete"
        items = entry.enumeration.items if entry.enumeration else ()
        found.append(
            Variable(
                name=placed.path,
                type=kind,
                causality=causality,
                variability=variability,
                unit=entry.unit,
                start=entry.start,
                shape=(entry.size,) if entry.size else (),
                minimum=entry.minimum,
                maximum=entry.maximum,
                description=entry.description,
                role=Role(entry.role) if entry.role else None,
                items={item.name: item.value for item in items} or None,
            )
        )
    return tuple(found)
