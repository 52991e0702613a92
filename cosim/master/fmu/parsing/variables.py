"""The variables of an FMU, from what FMPy read of them and what it passes over."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from math import prod
from pathlib import Path
from typing import Any

from cosim.base.component import Causality, Variable, VariableType
from cosim.master.components.parameters import misfit
from cosim.master.fmu.meanings import Meant

MOST_ELEMENTS = 1_000_000
"""Of an array."""
_TRUTHS = {"true": True, "1": True, "false": False, "0": False}


_FMI2_TYPES = {
    "Real": VariableType.FLOAT64,
    "Integer": VariableType.INT32,
    "Enumeration": VariableType.ENUMERATION,
    "Boolean": VariableType.BOOLEAN,
    "String": VariableType.STRING,
}


@dataclass(frozen=True, slots=True)
class Shapes:
    """The shapes of arrays, where structural parameters may have other values than their start."""

    structure: Mapping[str, int]
    by_reference: Mapping[int, str]
    """The name of the structural parameter behind a value reference."""

    def of(self, variable: Any) -> tuple[int, ...]:
        """Of one of FMPy's variables.

        Raises:
            ValueError: a dimension is below 0, or there are more elements than are carried.
        """
        shape = list[int](variable.shape or ())
        for place, dimension in enumerate(variable.dimensions):
            name = self.by_reference.get(dimension.valueReference, "")
            if name in self.structure:
                shape[place] = self.structure[name]
        if shape and min(shape) < 0:
            raise ValueError(f"it has a dimension of {min(shape)}")
        if prod(shape) > MOST_ELEMENTS:
            size = " × ".join(map(str, shape))
            raise ValueError(f"it has {size} elements, more than the {MOST_ELEMENTS} carried")
        return tuple(shape)


def variable_of(
    variable: Any,
    version: int,
    shapes: Shapes,
    meant: Meant,
    *,
    is_relative: bool | None,
    texts: tuple[str, ...],
) -> Variable:
    """The variable that FMPy read as ``variable``; ``texts`` are the starts of a Binary or String.

    Raises:
        ValueError: its start is none of its type, or its shape none that is carried.
    """
    kind = _FMI2_TYPES[variable.type] if version == 2 else VariableType(variable.type)
    declared = variable.declaredType
    unit = variable.unit or (declared.unit if declared is not None else None)
    items = _items(declared)
    return Variable(
        name=variable.name,
        type=kind,
        causality=Causality(variable.causality),
        variability=variable.variability,
        unit=unit,
        start=_text_start(texts or variable.start, kind)
        if kind.is_text
        else _start(variable.start, kind),
        shape=shapes.of(variable),
        minimum=_bound("min", variable.min),
        maximum=_bound("max", variable.max),
        description=variable.description or "",
        items=items or None,
        is_relative=is_relative
        if is_relative is not None
        else bool(declared is not None and declared.relativeQuantity),
        meaning=meant.meaning,
        belongs_to=meant.belongs_to,
    )


def relative_quantities(path: Path) -> dict[str, bool]:
    """What variables say of ``relativeQuantity`` themselves, which FMPy passes over."""
    if b"relativeQuantity" not in path.read_bytes():
        return {}
    found: dict[str, bool] = {}
    for variable in ET.parse(path).getroot().iterfind("ModelVariables/*"):
        for element in (variable, *variable.findall("Real")):
            if (word := element.get("relativeQuantity")) is not None:
                found[variable.get("name", "")] = word in {"true", "1"}
    return found


def text_starts(path: Path, version: int) -> dict[str, tuple[str, ...]]:
    """The starts of FMI 3's Strings and Binaries, of which FMPy reads an array's first alone."""
    if version == 2 or b"<Start" not in path.read_bytes():
        return {}
    variables = ET.parse(path).getroot().iterfind("ModelVariables/*")
    return {
        variable.get("name", ""): tuple(start.get("value", "") for start in starts)
        for variable in variables
        if (starts := variable.findall("Start"))
    }


def _text_start(given: Any, kind: VariableType) -> Any:
    """One text (or bytes, in XML hexadecimal) for all elements, or one for each.

    Raises:
        ValueError: it is not hexadecimal.
    """
    if given is None:
        return None
    texts: tuple[str, ...] = (given,) if isinstance(given, str) else given
    if kind is VariableType.STRING:
        return texts[0] if len(texts) == 1 else texts
    try:
        contents = tuple(bytes.fromhex(text) for text in texts)
    except ValueError:
        raise ValueError("its start is not hexadecimal, as that of a Binary has to be") from None
    return contents[0] if len(contents) == 1 else contents


def _items(declared: Any) -> dict[str, int]:
    """The numbers of an enumeration's items, by their names.

    Raises:
        ValueError: one is none.
    """
    found: dict[str, int] = {}
    if declared is None:
        return found
    for item in declared.items:
        try:
            found[item.name] = int(_plain(str(item.value)))
        except ValueError:
            said = f"{declared.name} has the item {item.name} with the value {item.value}"
            raise ValueError(f"its type {said}, which is no whole number") from None
    return found


def _bound(which: str, text: str | None) -> float | None:
    try:
        return None if text is None else float(_plain(text))
    except ValueError:
        raise ValueError(f"its {which}, {text}, is no number") from None


def _plain(word: str) -> str:
    """A number as XML writes it: Python takes 1_000 and digits of other scripts, too.

    Raises:
        ValueError: it is none.
    """
    if not word.isascii() or "_" in word:
        raise ValueError(word)
    return word


def _start(text: str | None, kind: VariableType) -> Any:
    if text is None:
        return None
    values = [_scalar(word, kind) for word in text.split()]
    return values[0] if len(values) == 1 else tuple(values)


def _scalar(word: str, kind: VariableType) -> float | int | bool:
    """One value of XML.

    Raises:
        ValueError: it is none of that type.
    """
    if kind is VariableType.BOOLEAN:
        if word not in _TRUTHS:
            raise ValueError(f"its start, {word}, is neither true nor false")
        return _TRUTHS[word]
    try:
        value = float(_plain(word)) if kind.is_float else int(_plain(word))
    except ValueError:
        raise ValueError(f"its start, {word}, is not of type {kind}") from None
    if problem := misfit(kind, value):
        raise ValueError(f"its start is {problem}")
    return value
