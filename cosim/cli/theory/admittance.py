"""``cohaptic theory admittance``: what a user feels, over frequency."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping
from typing import Any, get_args

import click
import numpy as np

from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.cli.theory.options import Loop, describe, emit, loop_options
from cosim.theory.models.parameters import Architecture
from cosim.theory.transparency.admittance import ARCHITECTURE_OF, Case, Felt, perceived


def _architecture_felt(values: Mapping[str, Any]) -> Architecture | None:
    """The architecture that ``--user`` belongs to; the ideal belongs to any."""
    felt = values["felt"]
    return None if felt in {None, "ideal"} else ARCHITECTURE_OF[felt]


@click.command(cls=JsonCommand)
@click.option("--case", type=click.Choice(get_args(Case)), default="free", show_default=True)
@click.option("--user", "felt", type=click.Choice(get_args(Felt)), help="Who feels it.")
@click.option(
    "--frequency",
    "frequencies",
    type=Number(0, 1e9, min_open=True),
    multiple=True,
    required=True,
    metavar="RAD/S",
    help="Repeatable.",
)
@loop_options(chapter=6, implied=_architecture_felt)
def command(
    loop: Loop, as_json: bool, case: Case, felt: Felt | None, frequencies: tuple[float, ...]
) -> None:
    """Perceived admittance by both definitions: V/F in free motion, X/F against the wall.

    frame_lifted holds the force over T_t and reads at the frame's start, (6.1); fundamental lets
    the force change at T_c and takes the harmonic at its own frequency.
    """
    felt_by_default: dict[str, Felt] = {"centralized": "remote", "single": "local"}
    user: Felt = felt or felt_by_default.get(loop.architecture, "distributed")
    found = perceived(loop.parameters, loop.timing, user, case, np.array(frequencies))
    unit = "m/(N·s)" if case == "free" else "m/N"
    rows = [
        {
            "frequency": frequency,
            "frame_lifted": _polar(complex(lifted)),
            "fundamental": _polar(complex(fundamental)),
            "impedance": {
                "frame_lifted": _polar(complex(1 / lifted)),
                "fundamental": _polar(complex(1 / fundamental)),
            },
        }
        for frequency, lifted, fundamental in zip(
            frequencies, found.frame_lifted, found.fundamental, strict=True
        )
    ]
    result = {
        "case": case,
        "user": user,
        "quantity": "velocity/force" if case == "free" else "position/force",
        "unit": unit,
        "admittance": rows,
        "architecture": loop.architecture,
        "parameters": loop.parameters.resolved(),
    }
    lines = [describe(loop), f"{user} user, {case}: admittance in {unit}"]
    for row, lifted, fundamental in zip(rows, found.frame_lifted, found.fundamental, strict=True):
        lines.append(
            f"  {row['frequency']:g} rad/s   frame-lifted {_text(complex(lifted))}"
            f"   fundamental {_text(complex(fundamental))}"
        )
    emit(result, "\n".join(lines), as_json=as_json, notes=loop.notes)


def _polar(value: complex) -> dict[str, float]:
    return {
        "magnitude": abs(value),
        "phase": cmath.phase(value),
        "phase_degrees": math.degrees(cmath.phase(value)),
    }


def _text(value: complex) -> str:
    return f"{abs(value):.5g} ∠ {math.degrees(cmath.phase(value)):.2f}°"
