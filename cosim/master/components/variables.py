"""What a Python component says of its variables, judged before anything is built on it."""

from __future__ import annotations

from collections.abc import Sequence
from enum import StrEnum
from math import prod
from typing import Any, cast

from cosim.base.component import Causality, Component, Variable, VariableType
from cosim.base.document.show import describe, show
from cosim.base.errors import InputError
from cosim.base.meaning import Meaning, Slot
from cosim.base.suggest import did_you_mean
from cosim.base.texts import encoded
from cosim.master.components.blame import written_at
from cosim.master.components.text_values import text_start


def checked_variables(component: Component) -> dict[str, Variable]:
    """The component's variables by name.

    Raises:
        InputError: they are no list of variables, two have one name, or one cannot be.
    """
    kind = type(component)
    where = f"{kind.__name__}.variables{written_at(kind.variables)}"
    given = cast("object", component.variables)
    if isinstance(given, str | bytes) or not isinstance(given, Sequence):
        raise InputError(f"{where} has to be a list of Variable, not {_described(given)}")
    found: dict[str, Variable] = {}
    for variable in cast("Sequence[object]", given):
        if not isinstance(variable, Variable):
            raise InputError(f"{where} has {_described(variable)} in it, which is no Variable")
        _check(where, variable)
        if variable.name in found:
            raise InputError(f"{where} has two variables named '{variable.name}'")
        found[variable.name] = variable
    return found


def _check(where: str, variable: Variable) -> None:
    name: Any = variable.name
    shape: Any = variable.shape
    if not isinstance(name, str) or not name.strip():
        raise InputError(f"{where} has a variable whose name is {describe(name)}")
    enumerations: list[tuple[str, object, type[StrEnum]]] = [
        ("type", variable.type, VariableType),
        ("causality", variable.causality, Causality),
    ]
    for key, value, kind in enumerations:
        if not isinstance(value, kind):
            names = [member.name for member in kind]
            hint = did_you_mean(str(value), names, listed=0)
            raise InputError(
                f"{where}: the {key} of '{name}' is {_described(value)}; it has to be a "
                f"{kind.__name__}, such as {kind.__name__}.{names[1]}.{hint}"
            )
    sizes: list[Any] = [*shape] if isinstance(shape, tuple) else [None]
    if not all(type(size) is int and size > 0 for size in sizes):
        raise InputError(
            f"{where}: the shape of '{name}' is {show(shape)}; it has to be (), (n,) or (n, m) "
            "with whole numbers above 0"
        )
    _check_meaning(where, variable)
    if variable.type.is_text:
        _check_text(where, variable)
    else:
        _check_start(where, variable)


def _check_meaning(where: str, variable: Variable) -> None:
    """One for all elements, or a tuple with one for each."""
    count = prod(variable.shape)
    wanted: list[tuple[str, object, Any]] = [
        ("meaning", variable.meaning, Meaning | None),
        ("belongs_to", variable.belongs_to, Slot),
    ]
    for key, value, kind in wanted:
        each = cast("tuple[object, ...]", value) if isinstance(value, tuple) else (value,) * count
        if len(each) != count or not all(isinstance(item, kind) for item in each):
            name = "Meaning" if key == "meaning" else "Slot"
            raise InputError(
                f"{where}: the {key} of '{variable.name}' is {_described(value)}; it has to be a "
                f"{name} of cosim.base.meaning, or a tuple of one for each element ({count})"
            )


def _check_start(where: str, variable: Variable) -> None:
    import numpy as np

    if variable.start is None:
        return
    try:
        start = np.asarray(variable.start, dtype=float)
    except (TypeError, ValueError):
        message = f"{where}: the start of '{variable.name}' is {_described(variable.start)}"
        raise InputError(f"{message}; it has to be a number or have its shape") from None
    if start.shape not in {(), variable.shape}:
        raise InputError(
            f"{where}: the start of '{variable.name}' has the shape {show(start.shape)}, the "
            f"variable {show(variable.shape)}"
        )


def _check_text(where: str, variable: Variable) -> None:
    """A String or Binary measures nothing, and starts with a value of its type."""
    kind, name = variable.type, variable.name
    if variable.unit is not None or variable.minimum is not None or variable.maximum is not None:
        raise InputError(f"{where}: '{name}' is a {kind}, which has no unit and no bounds")
    start = text_start(variable)
    given = variable.start
    if isinstance(given, tuple) and len(cast("tuple[object, ...]", given)) != len(start):
        raise InputError(f"{where}: the start of '{name}' needs {len(start)} values")
    for value in start:
        try:
            encoded(value, is_binary=kind is VariableType.BINARY)
        except (TypeError, ValueError) as error:
            raise InputError(f"{where}: the start of '{name}': {error}") from None


def _described(value: Any) -> str:
    if isinstance(value, type):
        return f"the class {value.__name__}"
    name = str(type(value).__name__)
    known = {"NoneType", "bool", "int", "float", "str", "dict", "list", "tuple"}
    return describe(value) if name in known else f"a {name}"
