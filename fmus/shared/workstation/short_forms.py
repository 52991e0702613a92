"""Short forms of a model's variables: one function a kind."""

from __future__ import annotations

from cosim.base.meaning import Meaning
from fmus.table import Enumeration, Group, ModelVariable


def real(
    name: str,
    description: str,
    unit: str,
    start: float | tuple[float, ...],
    *,
    minimum: float | None = None,
    size: int | None = None,
    meaning: Meaning | None = None,
    tunable: bool = False,
) -> ModelVariable:
    """A real parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        tunable=tunable,
        unit=unit,
        start=start,
        minimum=minimum,
        size=size,
        meaning=meaning,
    )


def integer(
    name: str,
    description: str,
    start: int,
    *,
    minimum: int,
    maximum: int,
    size: int | None = None,
    meaning: Meaning | None = None,
) -> ModelVariable:
    """An integer parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        type="integer",
        start=start,
        minimum=minimum,
        maximum=maximum,
        size=size,
        meaning=meaning,
    )


def choice(
    name: str,
    description: str,
    enumeration: Enumeration,
    start: int = 0,
    *,
    meaning: Meaning | None = None,
) -> ModelVariable:
    """An enumeration parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        type="enumeration",
        enumeration=enumeration,
        start=start,
        meaning=meaning,
    )


def switch(
    name: str, description: str, *, start: bool = False, meaning: Meaning | None = None
) -> ModelVariable:
    """A boolean parameter."""
    return ModelVariable(
        name=name,
        description=description,
        causality="parameter",
        type="boolean",
        start=start,
        meaning=meaning,
    )


def output(
    name: str,
    description: str,
    unit: str | None,
    depends_on: tuple[str, ...] = (),
    *,
    size: int | None = None,
    meaning: Meaning | tuple[Meaning, ...] | None = None,
    finger: int | None = None,
) -> ModelVariable:
    """A real output with a unit, an integer one without."""
    return ModelVariable(
        name=name,
        description=description,
        causality="output",
        type="real" if unit else "integer",
        unit=unit,
        size=size,
        meaning=meaning,
        finger=finger,
        depends_on=depends_on,
    )


def signal(
    name: str,
    description: str,
    unit: str | None,
    *,
    start: float = 0,
    size: int | None = None,
    meaning: Meaning | tuple[Meaning, ...] | None = None,
) -> ModelVariable:
    """A real input with a unit, an integer one without."""
    return ModelVariable(
        name=name,
        description=description,
        causality="input",
        type="real" if unit else "integer",
        unit=unit,
        start=float(start) if unit else int(start),
        size=size,
        meaning=meaning,
    )


def planar(
    name: str,
    description: str,
    units: tuple[str, str],
    depends_on: tuple[str, ...] = (),
    *,
    meaning: tuple[Meaning | None, Meaning | None, Meaning | None] = (None, None, None),
) -> Group:
    """A pose, velocity or wrench of the plane as an output group {x, y, theta}."""
    return Group(
        name,
        (
            output("x", f"{description}, x", units[0], depends_on, meaning=meaning[0]),
            output("y", f"{description}, y", units[0], depends_on, meaning=meaning[1]),
            output("theta", f"{description}, about z", units[1], depends_on, meaning=meaning[2]),
        ),
    )


POSE = ("m", "rad")


VELOCITY = ("m/s", "rad/s")


WRENCH = ("N", "N.m")


BOX_POSE = (Meaning.BOX_X, Meaning.BOX_Y, Meaning.BOX_ANGLE)
