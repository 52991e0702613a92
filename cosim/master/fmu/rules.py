"""What neither a schema nor FMPy says of a description: rules whose breach is noted, or refused.

A breach is harmless where what a variable is, where it is and how it is set is beyond doubt.
Everything else is refused, however lenient the scenario is.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Iterator
from math import prod
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import decimal

_TYPES = ("Real", "Integer", "Boolean", "String", "Enumeration")
_MOST_REFERENCE = 2**32 - 1
_TEXTS = {"String", "Binary"}


def judge(description: Any, path: Path, folder: Path, *, is_valid: bool) -> tuple[str, ...]:
    """The harmless breaches that nobody else has found; ``is_valid`` is what FMPy says.

    Raises:
        InputError: a rule is broken without which the FMU cannot be used.
    """
    where = f"the modelDescription.xml of {path}"
    names = Counter(variable.name for variable in description.modelVariables)
    twice = [name for name, count in names.items() if count > 1]
    if twice:
        raise InputError(f"{where} declares {twice[0]} twice")
    token = "guid" if description.fmiMajorVersion == 2 else "instantiationToken"
    if description.guid is None:
        raise InputError(f"{where} has no {token}, which its library compares: export it again")
    interface = description.coSimulation
    if interface is not None and not interface.modelIdentifier:
        raise InputError(f"{where} does not say what its library is called (modelIdentifier)")
    if interface is not None and set(interface.modelIdentifier) & set("/\\:"):
        raise InputError(
            f"{where} gives its library the name '{interface.modelIdentifier}', which is a path; "
            "a modelIdentifier is a name in C"
        )
    _check_times("DefaultExperiment", description.defaultExperiment, where)
    _check_times("CoSimulation", interface, where)
    if not is_valid and description.fmiMajorVersion == 2:
        _check_types(folder / "modelDescription.xml", where)
    breaches = [
        *_doubles("unit", description.unitDefinitions, where),
        *_doubles("type", description.typeDefinitions, where),
    ]
    for kind in description.typeDefinitions:
        _check_items(kind, where)
    for variable in description.modelVariables:
        try:
            breaches += _of_variable(variable)
        except ValueError as error:
            place = f"line {variable.sourceline} of {where}"
            raise InputError(f"{place}: {variable.name}: {error}") from None
    return tuple(breaches)


def _check_times(name: str, element: Any, where: str) -> None:
    """Those of the default experiment are numbers, and an FMU's own step is one."""
    for key in ("startTime", "stopTime", "tolerance", "stepSize", "fixedInternalStepSize"):
        text = getattr(element, key, None)
        try:
            if math.isfinite(float(text or 0)):
                decimal(str(text or 0))
        except ValueError:
            raise InputError(f"{where}: the {key} of its {name} is {text!r}") from None


def _check_types(file: Path, where: str) -> None:
    """FMI 2: each variable has one type, as an element inside it; FMPy takes any."""
    for variable in ET.parse(file).getroot().iterfind("ModelVariables/ScalarVariable"):
        found = [element.tag for element in variable if element.tag in _TYPES]
        if len(found) != 1:
            said = " and ".join(found) or "no type"
            raise InputError(f"{where}: {variable.get('name')} is of {said}; it has to be of one")


def _doubles(what: str, definitions: Iterable[Any], where: str) -> Iterator[str]:
    """Definitions of one name: the same ones are harmless."""
    known: dict[str, Any] = {}
    for each in definitions:
        other = known.setdefault(each.name, each)
        if other is each:
            continue
        if repr(other) != repr(each):
            raise InputError(f"{where} defines the {what} {each.name} twice, and differently")
        yield f"the {what} {each.name} is defined twice"


def _check_items(kind: Any, where: str) -> None:
    """An enumeration's names and numbers belong together one by one."""
    for key in ("name", "value"):
        counts = Counter(getattr(item, key) for item in kind.items)
        twice = [value for value, count in counts.items() if count > 1]
        if twice:
            raise InputError(f"{where}: {kind.name} has two items of {key} {twice[0]}")


def _of_variable(variable: Any) -> Iterator[str]:
    """Raises ``ValueError`` for what cannot be used."""
    reference = variable.valueReference
    if not 0 <= reference <= _MOST_REFERENCE:
        raise ValueError(f"its valueReference is {reference}; it is a whole number from 0 on")
    kind: Any = variable.declaredType if variable.type == "Enumeration" else None
    if kind is not None and kind.type != "Enumeration":
        raise ValueError(f"its type, {kind.name}, is no enumeration")
    if variable.type in _TEXTS or variable.start is None or variable.clocks:
        return
    starts = variable.start.split()
    size = prod(variable.shape or ())
    if len(starts) not in {1, size}:
        raise ValueError(f"it has {len(starts)} starts for {size} elements")
    if kind is not None and set(starts) - {str(item.value) for item in kind.items}:
        yield f'the start of "{variable.name}" is none of {kind.name}'
    if variable.type != "Boolean":
        yield from _of_range(variable, starts)


def _of_range(variable: Any, starts: list[str]) -> Iterator[str]:
    least, most = (None if text is None else float(text) for text in (variable.min, variable.max))
    if least is not None and most is not None and least > most:
        raise ValueError(f"its least value, {least:g}, is above its most, {most:g}")
    for value in map(float, starts):
        if (least is not None and value < least) or (most is not None and value > most):
            yield f'the start of "{variable.name}", {value:g}, is outside of its range'
            return
