"""A table that contradicts itself is refused with the variable's name; units are understood."""

from __future__ import annotations

from typing import Any

import pytest

from fmus.description import base_exponents
from fmus.layout import SlotLayout, elements_of
from fmus.table import Group, Model, ModelVariable, Terminal


def model(*variables: ModelVariable | Group, **more: Any) -> Model:
    return Model(name="m", description="", variables=variables, sources=(), **more)


def variable(name: str = "x", **more: Any) -> ModelVariable:
    defaults = {"description": "", "causality": "output", "unit": "1"}
    return ModelVariable(name=name, **(defaults | more))


@pytest.mark.parametrize(
    ("variables", "words"),
    [
        ([variable(), variable()], "'x' is there twice"),
        ([variable(causality="parameter")], "'x' needs a start value"),
        ([variable(start=1.0)], "cannot have a start value"),
        ([variable(causality="input", size=3, start=(1.0, 2.0))], "2 start values for 3"),
        ([variable(type="enumeration")], "must have an enumeration"),
        ([variable(unit=None)], "needs a unit"),
        ([variable(depends_on=("y",))], "depends on 'y', which is no input"),
    ],
)
def test_contradictions(variables: list[ModelVariable], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        SlotLayout(model(*variables))


def test_a_terminal_names_variables() -> None:
    terminal = Terminal(name="t", description="", members={"a": "nothing"})
    with pytest.raises(ValueError, match="terminal 't' has a member 'nothing'"):
        SlotLayout(model(variable(), terminals=(terminal,)))


def test_names_and_slots_of_groups_and_arrays() -> None:
    position = variable("position", size=2)
    layout = SlotLayout(
        model(variable("a"), Group("finger", (position, variable("mode", type="string")), count=2))
    )
    assert [(e.name, e.slot) for e in layout.elements] == [
        ("a", 0),
        ("finger_1.position[1]", 1),
        ("finger_1.position[2]", 2),
        ("finger_1.mode", 3),
        ("finger_2.position[1]", 67),
        ("finger_2.position[2]", 68),
        ("finger_2.mode", 69),
    ]
    assert layout.slots == 69 + 64


def test_dependencies_may_name_the_own_group_or_all() -> None:
    def finger(depends_on: str) -> SlotLayout:
        angle = variable("angle", causality="input", start=0.0)
        force = variable("force", depends_on=(depends_on,))
        return SlotLayout(model(Group("finger", (angle, force), count=2)))

    def known(layout: SlotLayout, path: str) -> list[str]:
        placed = layout.find(path)
        return [p.path for p in layout.matching(placed.variable.depends_on, placed.group)]

    assert known(finger("{group}.angle"), "finger_2.force") == ["finger_2.angle"]
    both = ["finger_1.angle", "finger_2.angle"]
    assert known(finger("finger_*.angle"), "finger_2.force") == both


def test_start_values_of_arrays() -> None:
    layout = SlotLayout(
        model(
            variable("a", causality="input", size=2, start=3.0),
            variable("b", causality="input", size=2, start=(1.0, 2.0)),
        )
    )
    assert [[e.start for e in elements_of(p)] for p in layout.placed] == [[3.0, 3.0], [1.0, 2.0]]


@pytest.mark.parametrize(
    ("unit", "exponents"),
    [
        ("1", {}),
        ("m", {"m": 1}),
        ("m/s", {"m": 1, "s": -1}),
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("N.s/m", {"kg": 1, "s": -1}),
        ("N.m", {"kg": 1, "m": 2, "s": -2}),
        ("kg.m2", {"kg": 1, "m": 2}),
        ("rad/s", {"s": -1, "rad": 1}),
        ("N.m.s/rad", {"kg": 1, "m": 2, "s": -1, "rad": -1}),
        ("N/(m.s)", {"kg": 1, "s": -3}),
        ("1/s", {"s": -1}),
        ("s-1", {"s": -1}),
        ("V/A", {"kg": 1, "m": 2, "s": -3, "A": -2}),
    ],
)
def test_units(unit: str, exponents: dict[str, int]) -> None:
    assert base_exponents(unit) == exponents


@pytest.mark.parametrize("unit", ["", "N/m.s", "mm", "N m", "furlong", "degC"])
def test_unknown_units_are_refused(unit: str) -> None:
    with pytest.raises(ValueError, match="unit"):
        base_exponents(unit)
