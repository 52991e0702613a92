"""A parameter of one of our models as a number, whichever way the scenario writes it."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING

from cosim.base.document.show import show
from cosim.base.errors import InputError
from cosim.base.quantities.quantity import QuantityError, quantity, split_quantity
from cosim.base.suggest import did_you_mean
from cosim.scenario import Scenario, ScenarioComponent

if TYPE_CHECKING:
    from fmus.layout import SlotLayout

AUTO = "auto"
"""What is computed from the others; until it is, the model's own value stands."""


def parameter(component: ScenarioComponent, name: str) -> float:
    """The scenario's value in the variable's unit, or the model's own start value.

    Raises:
        InputError: what is written is no such quantity.
    """
    value = component.parameters.get(name)
    known = _numbers(component.source)
    if name not in known:
        raise InputError(
            f"{component.name}: {component.source} has no number {name}.{did_you_mean(name, known)}"
        )
    start, unit = known[name]
    if value is None or value == AUTO:
        return start
    if isinstance(value, tuple):
        raise InputError(f"{component.name}.{name} is one number, not {show(value)}.")
    try:
        return float(quantity(value, unit or "1")) if isinstance(value, str) else float(value)
    except QuantityError as error:
        raise InputError(f"{component.name}.{name}: {error}") from None


def refuse_unknown_parameters(scenario: Scenario, component: ScenarioComponent) -> None:
    """Refuse what one of our models has no parameter for, and words that none of its choices is.

    For those who read a scenario without loading its FMUs, which would refuse it.

    Raises:
        InputError: by name and place.
    """
    known = _choices(component.source)
    for name, value in component.parameters.items():
        place = scenario.locate(("components", component.name, "parameters", *name.split(".")))
        path = name.partition("[")[0]
        if any(one.startswith(f"{path}.") for one in known):
            continue  # a word for a group, such as auto
        if path not in known:
            raise InputError(
                f"{component.name}: {component.source} has no parameter {name}."
                f"{did_you_mean(name, known)}",
                place,
            )
        for one in value if isinstance(value, tuple) else (value,):
            choices = known[path]
            if choices and one not in choices:
                words = [choice for choice in choices if isinstance(choice, str)]
                raise InputError(
                    f"{component.name}.{name} is {', '.join(words)}, not {show(one)}."
                    f"{did_you_mean(str(one), words)}",
                    place,
                )


def is_number(value: object) -> bool:
    """Whether a parameter's value is a number, with a unit or without."""
    if isinstance(value, str):
        try:
            return split_quantity(value)[1] is not None
        except QuantityError:
            return False
    return isinstance(value, int | float)


@cache
def layout_of(model: str) -> SlotLayout:
    """The variables of one of our models, as they are placed; ``.model`` is its table."""
    from fmus.layout import SlotLayout

    return SlotLayout(import_module(f"fmus.{model}.variables").MODEL)


@cache
def _numbers(model: str) -> Mapping[str, tuple[float, str | None]]:
    """Start value and unit of each number of a model, elements of arrays by themselves."""
    return {
        element.name: (float(element.start), element.variable.unit)
        for element in layout_of(model).elements
        if isinstance(element.start, int | float)
    }


@cache
def _choices(model: str) -> Mapping[str, tuple[str | int, ...]]:
    """Every parameter of a model, and of an enumeration its words and their numbers."""
    return {
        placed.path: tuple(
            choice
            for item in (placed.variable.enumeration.items if placed.variable.enumeration else ())
            for choice in (item.name, item.value)
        )
        for placed in layout_of(model).placed
        if placed.variable.causality == "parameter"
    }
