"""A probe that takes short steps only, so that its importer has to make several."""

from __future__ import annotations

from fmus.table import Model, ModelVariable

MODEL = Model(
    name="probe_substeps",
    description="Integrates its input; discards steps longer than maximum_step",
    sources=("model.c",),
    default_step=1 / 4096,
    variables=(
        ModelVariable(
            name="rate", description="What is integrated", causality="input", unit="1/s", start=1.0
        ),
        ModelVariable(name="integral", description="Its integral", causality="output", unit="1"),
        ModelVariable(name="steps", description="Steps done", causality="output", type="integer"),
        ModelVariable(
            name="maximum_step",
            description="Longest step that is taken",
            causality="parameter",
            unit="s",
            start=1 / 4096,
            minimum=0.0,
        ),
    ),
)
