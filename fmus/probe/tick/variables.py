"""A probe that says which tick it is at, and which tick it reads."""

from __future__ import annotations

from typing import Any

from fmus.table import Model, ModelVariable


def _integer(name: str, description: str, **more: Any) -> ModelVariable:
    return ModelVariable(name=name, description=description, type="integer", **more)


MODEL = Model(
    name="probe_tick",
    description="Reports its own tick and the tick of what it reads",
    sources=("model.c",),
    variables=(
        _integer("heard", "A tick, from another probe", causality="input", start=-1),
        ModelVariable(
            name="heard_real",
            description="A tick as a real number, from another probe",
            causality="input",
            unit="1",
            start=-1.0,
        ),
        _integer("tick", "Base ticks at the committed time", causality="output"),
        ModelVariable(name="tick_real", description="The same", causality="output", unit="1"),
        _integer("seen", "What is heard now", causality="output", depends_on=("heard",)),
        ModelVariable(
            name="seen_real",
            description="What is heard now",
            causality="output",
            unit="1",
            depends_on=("heard_real",),
        ),
        _integer("last_heard", "What was heard at the start of the last step", causality="output"),
        _integer("steps", "Steps done", causality="output"),
        _integer("period", "Base ticks in one step", causality="parameter", start=1, minimum=1),
        _integer("first_tick", "Tick at the start", causality="parameter", start=0),
    ),
)
