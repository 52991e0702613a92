"""The virtual coupler on one axis: a spring and a damper between two bodies."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.state import KeptReal
from fmus.table import Model, ModelVariable


def _input(name: str, description: str, unit: str) -> ModelVariable:
    return ModelVariable(
        name=name, description=description, causality="input", unit=unit, start=0.0
    )


_ALL = ("position_*", "velocity_*")

MODEL = Model(
    name="virtual_coupler",
    description="Virtual coupler: spring and damper between two bodies on one axis",
    sources=("model.c",),
    linear=True,
    state=tuple(
        KeptReal(
            path=f"force[{age}]", unit="N", step=1.0, when=f"computation_delay_ticks>={age + 1}"
        )
        for age in range(8)
    ),
    variables=(
        _input("position_a", "Position of body a", "m"),
        _input("velocity_a", "Velocity of body a", "m/s"),
        _input("position_b", "Position of body b", "m"),
        _input("velocity_b", "Velocity of body b", "m/s"),
        ModelVariable(
            name="force",
            description="Force on body b",
            causality="output",
            unit="N",
            meaning=Meaning.AXIS_FORCE,
            depends_on=_ALL,
        ),
        ModelVariable(
            name="reaction",
            description="Force on body a, the opposite one",
            causality="output",
            unit="N",
            depends_on=_ALL,
        ),
        ModelVariable(
            name="stiffness",
            description="Stiffness k",
            causality="parameter",
            tunable=True,
            unit="N/m",
            start=1000.0,
            minimum=0.0,
        ),
        ModelVariable(
            name="damping",
            description="Damping b",
            causality="parameter",
            tunable=True,
            unit="N.s/m",
            start=10.0,
            minimum=0.0,
        ),
        ModelVariable(
            name="computation_delay_ticks",
            description="Steps by which the force comes later than what it is computed from",
            causality="parameter",
            type="integer",
            start=0,
            minimum=0,
            maximum=8,
        ),
    ),
)
