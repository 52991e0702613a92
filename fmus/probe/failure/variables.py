"""A probe that fails at a chosen step in a chosen way."""

from __future__ import annotations

from fmus.table import Enumeration, Item, Model, ModelVariable

KIND = Enumeration(
    name="failure_kind",
    description="What goes wrong",
    items=(
        Item(name="none", value=0, description="Nothing"),
        Item(name="discard", value=1, description="The step is discarded"),
        Item(name="error", value=2, description="The step ends in an error"),
        Item(name="fatal", value=3, description="The step ends in a fatal error"),
        Item(name="nan", value=4, description="The output is not a number from then on"),
        Item(name="infinite", value=5, description="The output is infinite from then on"),
        Item(name="initialise", value=6, description="Initialisation is refused"),
        Item(name="crash", value=7, description="The process receives a signal"),
    ),
)

MODEL = Model(
    name="probe_failure",
    description="Fails at a chosen step in a chosen way",
    sources=("model.c",),
    variables=(
        ModelVariable(name="value", description="Steps done", causality="output", unit="1"),
        ModelVariable(
            name="input",
            description="Not used, to be connected",
            causality="input",
            unit="1",
            start=0.0,
        ),
        ModelVariable(
            name="kind",
            description="What goes wrong",
            causality="parameter",
            type="enumeration",
            enumeration=KIND,
            start=0,
        ),
        ModelVariable(
            name="at",
            description="Number of good steps before",
            causality="parameter",
            type="integer",
            start=0,
            minimum=0,
        ),
    ),
)
