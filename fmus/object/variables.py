"""The object on one axis: a mass under several held forces, a wall and a compensating force."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.state import KeptReal
from fmus.table import Model, ModelVariable

MODEL = Model(
    name="object",
    description="Object on one axis: a mass driven by held forces, discretised exactly",
    sources=("model.c",),
    linear=True,
    state=(
        KeptReal(path="position", unit="m", step=1.0),
        KeptReal(path="velocity", unit="m/s", step=1.0),
    ),
    variables=(
        ModelVariable(
            name="force",
            description="Forces on the object, which are added up; nine users need 17: the own "
            "hand's, and two for each of the others, hand and copy",
            causality="input",
            unit="N",
            start=0.0,
            size=17,
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
            description="Mass",
            causality="parameter",
            unit="kg",
            start=0.4,
            minimum=0.0,
        ),
        ModelVariable(
            name="compensation",
            description="Damping b_c of the force -b_c v, sampled from the object's own velocity "
            "and held over a step; a negative one compensates damping that the network adds",
            causality="parameter",
            tunable=True,
            unit="N.s/m",
            start=0.0,
        ),
        ModelVariable(
            name="wall_stiffness",
            description="Stiffness of a wall that the object stays in contact with; 0: no wall",
            causality="parameter",
            tunable=True,
            unit="N/m",
            start=0.0,
            minimum=0.0,
        ),
        ModelVariable(
            name="wall_damping",
            description="Damping of that wall",
            causality="parameter",
            tunable=True,
            unit="N.s/m",
            start=0.0,
            minimum=0.0,
        ),
        ModelVariable(
            name="wall_position",
            description="Position of the object at which the wall exerts no force",
            causality="parameter",
            unit="m",
            start=0.0,
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
