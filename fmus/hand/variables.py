"""A hand (and the device it holds) on one axis: a mass under two held forces."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.state import KeptReal
from fmus.table import Model, ModelVariable

MODEL = Model(
    name="hand",
    description="Hand on one axis: a mass driven by held forces, discretised exactly",
    sources=("model.c",),
    linear=True,
    state=(
        KeptReal(path="position", unit="m", step=1.0),
        KeptReal(path="velocity", unit="m/s", step=1.0),
    ),
    variables=(
        ModelVariable(
            name="force",
            description="Force of the user on the mass",
            causality="input",
            meaning=Meaning.AXIS_FORCE,
            unit="N",
            start=0.0,
        ),
        ModelVariable(
            name="coupler_force",
            description="Force of the virtual coupler on the mass",
            causality="input",
            unit="N",
            start=0.0,
        ),
        ModelVariable(
            name="position",
            description="Position",
            causality="output",
            unit="m",
            meaning=Meaning.AXIS_POSITION,
        ),
        ModelVariable(
            name="velocity",
            description="Velocity",
            causality="output",
            unit="m/s",
            meaning=Meaning.AXIS_VELOCITY,
        ),
        ModelVariable(
            name="mass",
            description="Mass of hand and device",
            causality="parameter",
            unit="kg",
            start=0.1,
            minimum=0.0,
        ),
        ModelVariable(
            name="initial_position",
            description="Position at the start",
            causality="parameter",
            unit="m",
            start=0.0,
        ),
        ModelVariable(
            name="initial_velocity",
            description="Velocity at the start",
            causality="parameter",
            unit="m/s",
            start=0.0,
        ),
    ),
)
