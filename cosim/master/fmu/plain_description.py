"""An FMU's description as plain values, to be kept, and back."""

from __future__ import annotations

from dataclasses import fields
from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import Any, cast

from cosim.base.component import Causality, Role, Variable, VariableType
from cosim.base.meaning import NO_SLOT, Meaning, Slot
from cosim.base.quantities.units import Unit
from cosim.master.fmu.description import FmuDescription

_VARIABLE = tuple(field.name for field in fields(Variable))
_UNIT = tuple(field.name for field in fields(Unit))
_TIMES = ("fixed_step", "step_size", "start_time", "stop_time")
_OWN = ("path", "folder", "variables", "at_events", "events", "units", *_TIMES)
_PLAIN = frozenset(_OWN)
"""Fields that need a form of their own; the others are plain values."""


def to_plain(description: FmuDescription) -> dict[str, Any]:
    """Everything but where the FMU lies."""
    content = {
        field.name: getattr(description, field.name)
        for field in fields(description)
        if field.name not in _PLAIN
    }
    times = {name: getattr(description, name) for name in _TIMES}
    return content | {
        "variables": [_row(each) for each in description.variables.values()],
        "at_events": [_row(each) for each in description.at_events],
        "units": {
            key: tuple(_ratio(getattr(unit, name)) for name in _UNIT)
            for key, unit in description.units.items()
        },
        **{name: None if time is None else time.as_integer_ratio() for name, time in times.items()},
    }


def from_plain(content: dict[str, Any], path: Path, folder: Path) -> FmuDescription:
    """The description that ``to_plain`` was given.

    Raises:
        KeyError, TypeError, ValueError: the content is another version's.
    """
    rest = dict(content)
    variables = [_variable(row) for row in rest.pop("variables")]
    at_events = tuple(_variable(row) for row in rest.pop("at_events"))
    units = {key: _unit(row) for key, row in rest.pop("units").items()}
    given = {name: rest.pop(name) for name in _TIMES}
    times = {name: None if time is None else Fraction(*time) for name, time in given.items()}
    return FmuDescription(
        path=path,
        folder=folder,
        variables={variable.name: variable for variable in variables},
        at_events=at_events,
        events=None,
        units=units,
        **times,
        **rest,
    )


def _row(variable: Variable) -> tuple[Any, ...]:
    return tuple(_member_value(getattr(variable, name)) for name in _VARIABLE)


def _member_value(value: Any) -> Any:
    """An enumeration's member as what it stands for, a slot as a list."""
    if isinstance(value, tuple):
        return tuple(_member_value(item) for item in cast("tuple[Any, ...]", value))
    if isinstance(value, Slot):
        return [value.peer, value.finger]
    return value.value if isinstance(value, Enum) else value


def _ratio(value: Any) -> Any:
    """A fraction as a list, which nothing else of a unit is."""
    return list(value.as_integer_ratio()) if isinstance(value, Fraction) else value


def _unit(row: tuple[Any, ...]) -> Unit:
    return Unit(**{name: _exact(value) for name, value in zip(_UNIT, row, strict=True)})


def _exact(value: Any) -> Any:
    return Fraction(*value) if type(value) is list else value  # pyright: ignore[reportUnknownArgumentType]


def _variable(row: tuple[Any, ...]) -> Variable:
    values = dict(zip(_VARIABLE, row, strict=True))
    values["type"] = _TYPES[values["type"]]
    values["causality"] = _CAUSALITIES[values["causality"]]
    role = values["role"]
    values["role"] = None if role is None else Role(role)
    values["meaning"] = _meaning(values["meaning"])
    values["belongs_to"] = _slot_of(values["belongs_to"])
    return Variable(**values)


def _meaning(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_meaning(item) for item in cast("tuple[Any, ...]", value))
    return None if value is None else Meaning(value)


def _slot_of(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(_slot_of(item) for item in cast("tuple[Any, ...]", value))
    return Slot(*value) if value != _NO_SLOT else NO_SLOT


_NO_SLOT = [None, None]
_TYPES = {str(member): member for member in VariableType}
_CAUSALITIES = {str(member): member for member in Causality}
