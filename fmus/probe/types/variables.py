"""A probe with every type of variable: each output is its input of the same kind, negated."""

from __future__ import annotations

from typing import Any

from fmus.table import Causality, Enumeration, Item, Model, ModelVariable, Type

COLOUR = Enumeration(
    name="colour",
    description="Three colours",
    items=(
        Item(name="red", value=1, description="Red"),
        Item(name="green", value=2, description="Green"),
        Item(name="blue", value=4, description="Blue"),
    ),
)


def _both(name: str, kind: Type, start: Any, size: int | None = None) -> tuple[ModelVariable, ...]:
    def one(suffix: str, causality: Causality) -> ModelVariable:
        return ModelVariable(
            name=f"{name}_{suffix}",
            description=f"{name} {suffix}",
            causality=causality,
            type=kind,
            unit="1" if kind == "real" else None,
            size=size,
            enumeration=COLOUR if kind == "enumeration" else None,
            start=start if causality != "output" else None,
            depends_on=(f"{name}_in",) if causality == "output" else (),
        )

    return one("in", "input"), one("out", "output"), one("parameter", "parameter")


MODEL = Model(
    name="probe_types",
    description="Has variables of every type, scalars and arrays",
    sources=("model.c",),
    variables=(
        *_both("real", "real", 0.5),
        *_both("integer", "integer", -3),
        *_both("boolean", "boolean", True),
        *_both("enumeration", "enumeration", 4),
        *_both("string", "string", 'a "string" <&> ü \\'),
        *_both("reals", "real", (1.0, 2.0, 3.0), 3),
        *_both("integers", "integer", 7, 2),
        *_both("booleans", "boolean", False, 2),
        *_both("strings", "string", "one", 2),
    ),
)
