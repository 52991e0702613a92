"""A probe with canHandleVariableCommunicationStepSize=false."""

from __future__ import annotations

from fmus.table import Model, ModelVariable

MODEL = Model(
    name="probe_fixed_step",
    description="Counts its steps, which must all have one length",
    sources=("model.c",),
    variable_step=False,
    variables=(
        ModelVariable(name="steps", description="Steps done", causality="output", type="integer"),
        ModelVariable(
            name="end", description="Where the last step ended", causality="output", unit="s"
        ),
    ),
)
