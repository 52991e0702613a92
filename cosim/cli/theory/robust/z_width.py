"""``cohaptic theory robust z-width``: by rule, by eigenvalues, and as it is built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import click
import numpy as np

from cosim.base.errors import InputError
from cosim.cli.support.command import JsonCommand
from cosim.cli.support.values import Number
from cosim.cli.theory.support.loop import emit
from cosim.theory.numerics import Real
from cosim.theory.robust.z_width import RenderedWall, as_built, by_eigenvalues, by_rule

DEFAULTS: dict[str, Any] = {
    "mass": 0.1,
    "device_damping": 0.1,
    "control_rate": 1024.0,
    "computation_delay": 0,
    "count": 2e-5,
    "window": 16,
}
"""Of a device that no scenario describes."""


@dataclass(frozen=True, slots=True)
class _Answer:
    """A device, the stiffest walls as it is built, and what there is to say about it."""

    device: RenderedWall
    built: Real
    place: str
    notes: tuple[str, ...] = ()


@click.command(cls=JsonCommand)
@click.option("--mass", type=Number(1e-4, 100), metavar="M", help="kg.  [default: 0.1]")
@click.option(
    "--device-damping",
    type=Number(0, 1e4),
    metavar="B",
    help="Physical, N·s/m.  [default: 0.1]",
)
@click.option("--control-rate", type=Number(1, 1e6), metavar="HZ", help="1 / T_c.  [default: 1024]")
@click.option(
    "--computation-delay",
    type=click.IntRange(0, 50),
    metavar="TICKS",
    help="From measurement to force.  [default: 0]",
)
@click.option(
    "--count",
    type=Number(0, 0.01),
    metavar="M",
    help="Of the encoder, at the tip.  [default: 2e-05]",
)
@click.option(
    "--window",
    type=click.IntRange(0, 64),
    metavar="TICKS",
    help="Longest window of the velocity (FOAW); 0: true.  [default: 16]",
)
@click.option(
    "--most",
    type=Number(0.1, 1e4),
    default=20.0,
    show_default=True,
    metavar="B",
    help="Largest damping of the wall, N·s/m.",
)
@click.option("--scenario", metavar="FILE", help="The device of a scenario, simulated as it is.")
@click.option("--with", "overlays", multiple=True, metavar="FILE", help="Overlay for it.")
@click.option(
    "--set", "settings", multiple=True, metavar="PATH=VALUE", help="Override in it; repeatable."
)
@click.option(
    "--finger", metavar="NAME", help="With --scenario: which device.  [default: its first]"
)
@click.option(
    "--axis",
    type=click.Choice(["x", "y"]),
    help="With --scenario: the wall's normal.  [default: x]",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def command(
    *,
    most: float,
    scenario: str | None,
    overlays: tuple[str, ...],
    settings: tuple[str, ...],
    finger: str | None,
    axis: str | None,
    as_json: bool,
    **given: Any,
) -> None:
    """The stiffest wall over its damping: K < (b + B)/(T/2 + t_d) beside what holds.

    By eigenvalues with the true velocity, and simulated with encoder counts and the estimator. With
    --scenario mass, damping and delay are those of its device at the tip, and the simulation is the
    kernel's: its encoders, DAC, amplifier, dry friction and estimator.
    """
    damping = np.linspace(most / 8, most, 8)
    if scenario is None:
        for name, value in (("--finger", finger), ("--axis", axis)):
            if value is not None:
                raise InputError(f"{name} is about a scenario's device: give --scenario FILE too.")
        if overlays or settings:
            raise InputError("--with and --set change a scenario: give --scenario FILE too.")
        answer = _of_numbers(given, damping)
    else:
        for name, value in given.items():
            if value is not None:
                raise InputError(
                    f"--{name.replace('_', '-')} describes a device, and {scenario} has its own: "
                    "leave it out, or change the scenario with --set."
                )
        answer = _of_scenario((scenario, overlays, settings), finger, axis or "x", damping)
    rows = [
        {
            "damping": float(one),
            "by_rule": by_rule(answer.device, float(one)),
            "by_eigenvalues": by_eigenvalues(answer.device, float(one)),
            "as_built": float(simulated),
        }
        for one, simulated in zip(damping, answer.built, strict=True)
    ]
    device = {
        "mass": answer.device.mass,
        "damping": answer.device.damping,
        "control_rate": 1.0 / answer.device.period,
        "computation_delay": answer.device.delay,
        "count": answer.device.count,
    }
    lines = [answer.place] if answer.place else []
    lines.append("wall damping  by rule  by eigenvalues  as built (N·s/m, N/m)")
    lines += [
        f"{row['damping']:12.4g} {row['by_rule']:8.0f} {row['by_eigenvalues']:15.0f} "
        f"{row['as_built']:9.0f}"
        for row in rows
    ]
    result = {"z_width": rows, "device": device}
    emit(result, "\n".join(lines), as_json=as_json, notes=answer.notes)


def _of_numbers(given: dict[str, Any], damping: Real) -> _Answer:
    values = {name: DEFAULTS[name] if value is None else value for name, value in given.items()}
    device = RenderedWall(
        values["mass"],
        values["device_damping"],
        1.0 / values["control_rate"],
        values["computation_delay"],
        values["count"],
        values["window"],
    )
    return _Answer(device, as_built(device, damping), "")


def _of_scenario(
    files: tuple[str, tuple[str, ...], tuple[str, ...]],
    finger: str | None,
    axis: str,
    damping: Real,
) -> _Answer:
    from cosim.analysis.answers.device_of_wall import find_device
    from cosim.analysis.answers.rendered_wall import PRESSED, WallOfDevice
    from cosim.scenario.load import read

    written = read(*files)
    chosen = find_device(written.built(), finger, "xy".index(axis))
    with WallOfDevice(written, chosen) as wall:
        facts = wall.facts
        place = (
            f"{chosen.device.name}, a wall across {axis}: {facts.mass * 1e3:.4g} g and "
            f"{facts.damping:.3g} N·s/m at the tip, a count {facts.count * 1e6:.3g} µm, "
            f"{facts.delay} ticks from torque to effect"
        )
        note = (
            f"As built: a hand presses with {PRESSED:g} N; encoders, DAC, amplifier, friction and "
            "estimator as in the scenario."
        )
        return _Answer(facts, wall.as_built([float(one) for one in damping]), place, (note,))
