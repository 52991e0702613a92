"""The device parameters as variables, read from ``device_parameters.h`` so that they exist once."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Literal

from cosim.base.meaning import Meaning
from fmus.table import Enumeration, Item, ModelVariable

HEADER = Path(__file__).with_name("device_parameters.h")

DEVICE = Enumeration(
    name="Device",
    description="Which device's parameters stand in for those that are left at -1",
    items=(
        Item(name="quanser", value=0, description="Quanser-like pantograph, direct drive"),
        Item(name="haply", value=1, description="Haply-2DIY-v3-like"),
        Item(name="custom", value=2, description="no preset: every parameter must be given"),
    ),
)

_MEANT = {
    "proximal_length": Meaning.PROXIMAL_LENGTH,
    "base_distance": Meaning.BASE_DISTANCE,
}
"""What others look for among the entries of the header."""

_ENTRY = re.compile(
    r"X\((?P<type>real|integer), (?P<name>\w+), \"(?P<unit>[^\"]+)\", (?P<quanser>[^,]+), "
    r"(?P<haply>[^,]+), \"(?P<description>[^\"]+)\"\)"
)


@cache
def presets(section: Literal["GEOMETRY", "DYNAMICS"]) -> dict[str, tuple[float, float]]:
    """Values of the (Quanser-like, Haply-like) device by parameter name, SI units."""
    return {
        entry["name"]: (float(entry["quanser"]), float(entry["haply"]))
        for entry in _entries(section)
    }


def device_choice(description: str = "Preset of the device") -> ModelVariable:
    """The parameter that chooses the preset."""
    return ModelVariable(
        name="device",
        description=description,
        causality="parameter",
        type="enumeration",
        enumeration=DEVICE,
        meaning=Meaning.DEVICE_PRESET,
        start=0,
    )


def device_parameters(section: Literal["GEOMETRY", "DYNAMICS"]) -> tuple[ModelVariable, ...]:
    """One parameter for each entry of a list in the header; -1 takes the preset's value."""
    return tuple(
        ModelVariable(
            name=entry["name"],
            description=f"{entry['description'][0].upper()}{entry['description'][1:]}. -1: the "
            f"preset's, {entry['quanser']} (Quanser-like) or {entry['haply']} (Haply-like)",
            causality="parameter",
            type="integer" if entry["type"] == "integer" else "real",
            unit=entry["unit"] if entry["type"] == "real" else None,
            start=-1 if entry["type"] == "integer" else -1.0,
            minimum=-1,
            meaning=_MEANT.get(entry["name"], Meaning.OWN_DEVICE),
        )
        for entry in _entries(section)
    )


def placement_parameters() -> tuple[ModelVariable, ...]:
    """Where the device stands in the world: SE(2) of the device's frame."""
    return (
        ModelVariable(
            name="base_x",
            description="World x of the device frame's origin, the axis of motor 1",
            causality="parameter",
            unit="m",
            start=0.0,
            meaning=Meaning.BASE_X,
        ),
        ModelVariable(
            name="base_y",
            description="World y of the device frame's origin, the axis of motor 1",
            causality="parameter",
            unit="m",
            start=0.0,
            meaning=Meaning.BASE_Y,
        ),
        ModelVariable(
            name="base_angle",
            description="Angle of the device's x axis (motor 1 to motor 2) in the world",
            causality="parameter",
            unit="rad",
            start=0.0,
            meaning=Meaning.BASE_ANGLE,
        ),
    )


def _entries(section: str) -> list[dict[str, str]]:
    block = re.search(
        rf"#define DEVICE_{section}\(X\)(?P<body>(?:.*\\\n)+.*\n)", HEADER.read_text("utf-8")
    )
    assert block is not None, f"{HEADER} has no list DEVICE_{section}"
    return [match.groupdict() for match in _ENTRY.finditer(block["body"])]
