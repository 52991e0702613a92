"""A scenario's values for a component's variables: names, types, sizes and bounds are checked."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Any

from cosim.base.component import Causality, Variable, VariableType
from cosim.base.document.show import show, truth_hint
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, quantity
from cosim.base.quantities.units import Unit, unit_of
from cosim.base.suggest import did_you_mean, index_hint
from cosim.master.components.interface import size_of, variable_elements
from cosim.master.components.text_values import text_start, written_text

_INDEXED = re.compile(r"(.+)\[\d+(?:,\d+)*\]")
"""An element; ``p[Color.red]`` is a name of its own."""
FLOAT32_MAX = (2 - 2**-23) * 2.0**127
SETTABLE = frozenset({Causality.PARAMETER, Causality.STRUCTURAL_PARAMETER})
STARTABLE = frozenset({Causality.INPUT, Causality.OUTPUT, Causality.LOCAL})


def resolve_values(
    component: str,
    variables: Mapping[str, Variable],
    name: str,
    value: Any,
    allowed: frozenset[Causality],
    *,
    units: Mapping[str, Unit] = MappingProxyType({}),
) -> dict[str, list[Any]]:
    """The elements that one written value gives, by variable name: numbers, booleans or text.

    ``name`` may be an array's base: ``motor_torque`` with a list sets ``motor_torque[1]`` and so
    on. ``units`` are those that the component defines itself, by name.

    Raises:
        InputError: no such variable, one that cannot be set, or a value that does not fit.
    """
    variable = variables.get(name)
    if variable is not None:
        _check_causality(component, variable, allowed)
        return {name: _elements(component, variable, value, units)}
    parts = sorted(
        (
            variable
            for variable in variables.values()
            if (match := _INDEXED.fullmatch(variable.name)) and match.group(1) == name
        ),
        key=lambda variable: [int(i) for i in variable.name[len(name) + 1 : -1].split(",")],
    )
    if not parts:
        members = [v.removeprefix(f"{name}.") for v in variables if v.startswith(f"{name}.")]
        if members and isinstance(value, str):
            raise InputError(
                f"{component}.{name} is a group of numbers ({', '.join(members)}); a word in "
                f"their place ({value}) is computed by cohaptic.load, and cosim.scenario.load "
                "was used"
            )
        whole = variables.get(name.partition("[")[0]) if name.endswith("]") else None
        if whole is not None and whole.shape:
            size = " × ".join(map(str, whole.shape))
            raise InputError(
                f"{component}.{whole.name} is an array ({size}); give the whole of it, as a list"
            )
        known = [v.name.split("[")[0] for v in variables.values() if v.causality in allowed]
        raise InputError(
            f"{component} has no {_kind(allowed)} '{name}'."
            f"{index_hint(name) or did_you_mean(name, known)}"
        )
    for part in parts:
        _check_causality(component, part, allowed)
    values = _flat(value) if isinstance(value, Sequence) and not isinstance(value, str) else None
    if values is None or len(values) != len(parts):
        raise InputError(
            f"{component}.{name} has {len(parts)} elements; give a list of {len(parts)} values"
        )
    return {
        part.name: _elements(component, part, item, units)
        for part, item in zip(parts, values, strict=True)
    }


def element_start(variable: Variable) -> list[Any]:
    """The declared start of each element; zero, false or empty where none is declared."""
    if variable.type.is_text:
        return text_start(variable)
    start: Any = variable.start
    count = size_of(variable)
    if start is None:
        return [0] * count
    if isinstance(start, tuple):
        values = _flat(start)  # pyright: ignore[reportUnknownArgumentType]
        return values if len(values) == count else [0] * count
    return [start] * count


def _check_causality(component: str, variable: Variable, allowed: frozenset[Causality]) -> None:
    if variable.causality not in allowed:
        raise InputError(
            f"{component}.{variable.name} is of causality '{variable.causality}', not "
            f"{'a' if Causality.PARAMETER in allowed else 'an'} {_kind(allowed)}"
            + (
                "; give an input's first value under 'start'"
                if variable.causality is Causality.INPUT
                else ""
            )
        )
    if variable.variability == "constant":
        raise InputError(f"{component}.{variable.name} is a constant and cannot be set")


def _kind(allowed: frozenset[Causality]) -> str:
    return "parameter" if Causality.PARAMETER in allowed else "input, output or local variable"


def _elements(
    component: str, variable: Variable, value: Any, units: Mapping[str, Unit]
) -> list[Any]:
    if not variable.shape:
        return [_convert(component, variable, variable.name, value, units)]
    values: list[Any] | None = (
        _flat(value)  # pyright: ignore[reportUnknownArgumentType]
        if isinstance(value, (list, tuple))
        else None
    )
    if values is None or len(values) != size_of(variable):
        raise InputError(
            f"{component}.{variable.name} has {size_of(variable)} elements; give a list of "
            f"{size_of(variable)} values"
        )
    if _shape(value) not in {(len(values),), variable.shape}:
        size = " × ".join(map(str, variable.shape))
        raise InputError(
            f"{component}.{variable.name} is {size}; give a list of its {len(values)} values, or "
            "lists in a list that have its shape"
        )
    return [
        _convert(component, variable, name, item, units)
        for (name, _), item in zip(variable_elements(variable), values, strict=True)
    ]


def _shape(value: Any) -> tuple[int, ...] | None:
    """Of lists in lists; ``None`` where they are of different lengths."""
    if not isinstance(value, (list, tuple)):
        return ()
    inner = {_shape(item) for item in value}  # pyright: ignore[reportUnknownVariableType]
    if len(inner) != 1 or None in inner:
        return None
    return (len(value), *(inner.pop() or ()))  # pyright: ignore[reportUnknownArgumentType]


def _flat(value: Any) -> list[Any]:
    flat: list[Any] = []
    for item in value:
        if isinstance(item, (list, tuple)):
            flat += _flat(item)
        else:
            flat.append(item)
    return flat


def _convert(
    component: str, variable: Variable, name: str, value: Any, units: Mapping[str, Unit]
) -> Any:
    kind = variable.type
    where = f"{component}.{name}"
    if kind.is_text:
        return written_text(where, value, is_binary=kind is VariableType.BINARY)
    if kind is VariableType.BOOLEAN:
        if not isinstance(value, bool):
            raise InputError(f"{where} is true or false, not {show(value)}{truth_hint(value)}")
        return value
    if kind is VariableType.ENUMERATION:
        return _item(where, variable, value)
    if isinstance(value, str):
        unit = variable.unit or "1"
        known = units.get(unit) or unit_of(unit)
        value = _quantity(where, known, value, units, difference=variable.is_relative)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{where} is a number, not {show(value)}")
    if isinstance(value, float) and not kind.is_float and not value.is_integer():
        raise InputError(f"{where} is a whole number, not {show(value)}")
    if problem := misfit(kind, value):
        raise InputError(f"{where} is {problem}")
    _check_bounds(where, variable, value)
    return float(value) if kind.is_float else int(value)


def misfit(kind: VariableType, value: float) -> str:
    """Why a number cannot be carried as this type: the end of a sentence, or nothing."""
    if kind.is_float:
        most = FLOAT32_MAX if kind is VariableType.FLOAT32 else sys.float_info.max
        if most < abs(value) < math.inf:
            return f"of type {kind}, which ends at {most:g}, and cannot be {_brief(value)}"
        return ""
    limits = kind.limits
    if limits is None or limits[0] <= value <= limits[1]:
        return ""
    return (
        f"of type {kind}, which goes from {limits[0]} to {limits[1]}"
        f"{' here' if kind is VariableType.UINT64 else ''}, and cannot be {_brief(value)}"
    )


def _brief(value: float) -> str:
    """The number as it was written, unless it has more digits than anybody reads."""
    text = str(value)
    return text if len(text) <= 24 else f"{text[:12]}… ({len(text)} digits)"


def _quantity(
    where: str, unit: Unit, text: str, own: Mapping[str, Unit], *, difference: bool
) -> float:
    """``2.44 ms`` in the variable's unit."""
    try:
        return float(quantity(text, unit, own=own, difference=difference))
    except QuantityError as error:
        raise InputError(f"{where} is a number: {error}") from None


def _item(where: str, variable: Variable, value: Any) -> int:
    items = variable.items or {}
    if isinstance(value, str):
        if value not in items:
            known = did_you_mean(value, items)
            raise InputError(f"{where} has no value '{value}'.{known}")
        return items[value]
    if isinstance(value, bool) or not isinstance(value, int):
        raise InputError(f"{where} is one of {', '.join(items)}, not {show(value)}")
    if items and value not in items.values():
        raise InputError(f"{where} has no value {value}; there are {', '.join(items)}")
    if problem := misfit(VariableType.ENUMERATION, value):
        raise InputError(f"{where} is {problem}")
    return value


def _check_bounds(where: str, variable: Variable, value: float) -> None:
    unit = f" {variable.unit}" if variable.unit and variable.unit != "1" else ""
    if math.isnan(value):
        raise InputError(f"{where} is not a number")
    if variable.minimum is not None and value < variable.minimum:
        raise InputError(
            f"{where} is {value:g}{unit}; the least that it can be is {variable.minimum:g}{unit}"
        )
    if variable.maximum is not None and value > variable.maximum:
        raise InputError(
            f"{where} is {value:g}{unit}; the most that it can be is {variable.maximum:g}{unit}"
        )
