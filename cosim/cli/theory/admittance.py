"""``cohaptic theory admittance``: what a user feels, over frequency."""

from __future__ import annotations

import cmath
import math
from collections.abc import Mapping, Sequence
from typing import Any, get_args

import click
import numpy as np

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.cli.theory.support.loop import Loop, describe, emit
from cosim.cli.theory.support.options import loop_options
from cosim.cli.theory.support.run_options import RunLoop
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
@click.option("--hand", metavar="NAME", help="With --scenario: the hand or operator that feels it.")
@click.option(
    "--axis", type=click.Choice(["x", "y"]), help="With --scenario: along which axis.  [default: x]"
)
@loop_options(chapter=6, implied=_architecture_felt, runs=True)
def command(
    *,
    loop: Loop | RunLoop,
    as_json: bool,
    case: Case,
    felt: Felt | None,
    hand: str | None,
    axis: str | None,
    frequencies: tuple[float, ...],
) -> None:
    """Perceived admittance by both definitions: V/F in free motion, X/F against the wall.

    frame_lifted holds the force over T_t and reads at the frame's start, (6.1); fundamental lets
    the force change at T_c and takes the harmonic at its own frequency.
    """
    if isinstance(loop, RunLoop):
        if felt is not None:
            raise InputError("--user is a user of chapter 6: name a hand of the run with --hand.")
        _of_run(loop, case, hand, axis, frequencies, as_json=as_json)
        return
    if hand is not None or axis is not None:
        raise InputError("--hand and --axis belong to a run: give --scenario FILE too.")
    felt_by_default: dict[str, Felt] = {"centralized": "remote", "single": "local"}
    user: Felt = felt or felt_by_default.get(loop.architecture, "distributed")
    found = perceived(loop.parameters, loop.timing, user, case, np.array(frequencies))
    unit = "m/(N·s)" if case == "free" else "m/N"
    rows = _rows(frequencies, found.frame_lifted, found.fundamental)
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
    lines += _lines(frequencies, found.frame_lifted, found.fundamental)
    emit(result, "\n".join(lines), as_json=as_json, notes=loop.notes)


def _of_run(
    loop: RunLoop,
    case: Case,
    hand: str | None,
    axis: str | None,
    frequencies: tuple[float, ...],
    *,
    as_json: bool,
) -> None:
    from cosim.analysis.answers.felt import felt_response
    from cosim.analysis.answers.push import find_push
    from cosim.analysis.monodromy.refusal import refuse_chance
    from cosim.cli.theory.support.run_answer import about, place

    with loop.asked() as asked:
        refuse_chance(asked.scenario, "admittance is")
        number = 1 if about(asked)["architecture"] == "centralized" else 0
        push = find_push(asked.scenario, hand, "xy".index(axis or "x"), number)
        found = felt_response(asked.point(), push, case, np.array(frequencies))
        unit = "m/(N·s)" if case == "free" else "m/N"
        result = {
            "case": case,
            "user": push.hand,
            "quantity": "velocity/force" if case == "free" else "position/force",
            "unit": unit,
            "admittance": _rows(frequencies, found.frame_lifted, found.fundamental),
            **about(asked),
        }
        lines = [place(asked), f"{push.hand}, {case}: admittance in {unit}"]
        lines += _lines(frequencies, found.frame_lifted, found.fundamental)
        emit(result, "\n".join(lines), as_json=as_json, notes=asked.notes)


def _rows(frequencies: Sequence[float], lifted: Any, fundamental: Any) -> list[dict[str, Any]]:
    return [
        {
            "frequency": frequency,
            "frame_lifted": _polar(complex(one)),
            "fundamental": _polar(complex(other)),
            "impedance": {
                "frame_lifted": _polar(complex(1 / one)),
                "fundamental": _polar(complex(1 / other)),
            },
        }
        for frequency, one, other in zip(frequencies, lifted, fundamental, strict=True)
    ]


def _lines(frequencies: Sequence[float], lifted: Any, fundamental: Any) -> list[str]:
    return [
        f"  {frequency:g} rad/s   frame-lifted {_text(complex(one))}"
        f"   fundamental {_text(complex(other))}"
        for frequency, one, other in zip(frequencies, lifted, fundamental, strict=True)
    ]


def _polar(value: complex) -> dict[str, float]:
    return {
        "magnitude": abs(value),
        "phase": cmath.phase(value),
        "phase_degrees": math.degrees(cmath.phase(value)),
    }


def _text(value: complex) -> str:
    return f"{abs(value):.5g} ∠ {math.degrees(cmath.phase(value)):.2f}°"
