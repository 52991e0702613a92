"""A preset of the simulated pantograph: what was measured, and what is assumed beside it.

The file goes under the parameters of a pantograph (``parameters: {include: haply_5573.yaml}``).
Each measured value has its interval beside it; what the runs do not tell is left to the published
device's, and said to be assumed.
"""

from __future__ import annotations

from cosim.identification.nominal import Nominal
from cosim.identification.regressor import INERTIAS
from cosim.identification.report import assumptions
from cosim.identification.results import CONFIDENCE, Estimate, Identified


def preset(found: Identified, name: str) -> str:
    """The text of a preset file that is to be called ``name``."""
    bar, device = found.described.bar, found.described.preset
    nominal = Nominal.of(device)
    lines = [
        "# A measured pantograph, by 'cohaptic identify'. In a scenario, under the parameters of a",
        f"# pantograph: 'parameters: {{include: {name}}}'. Intervals are {CONFIDENCE:.0%}.",
        "#",
        "# Measured from",
    ]
    for run in found.runs:
        loaded = "" if not run.payload else f", with {run.payload * 1e3:g} g on the tip"
        lines.append(f"#   {run.name}{loaded}, {run.date or 'no date'}, digest {run.digest}")
    lines += ["# Assumed: " + each for each in assumptions(found)]
    lines += [f"# The residual is {'' if found.white.is_white else 'NOT '}white.", ""]
    lines += [
        f"device: {device}   # what is not below is this device's: assumed",
        f"proximal_length: {bar.proximal:.9g}   # m, of the device file or the model",
        f"distal_length: {bar.distal:.9g}",
        f"base_distance: {bar.base:.9g}",
    ]
    return "\n".join([*lines, *_inertia(found, nominal), *_rest(found), *_comments(found)]) + "\n"


def _inertia(found: Identified, nominal: Nominal) -> list[str]:
    """Links whose energy is the measured one; J, M and phi are three numbers, links have four."""
    bar, names = found.described.bar, [each.name for each in INERTIAS]
    whole = [found[name] for name in names]
    values = [0.0 if each.value is None else each.value for each in whole]
    unknown = [each.name for each in whole if each.value is None]
    if {"J_1", "J_2", "M"} & set(unknown):
        return [f"# {', '.join(unknown)}: not identifiable from these runs; all inertia is assumed"]
    nu = nominal.nu(bar)
    phi = (values[3] + values[4]) / 2
    lines: list[str] = []
    if {"phi_1", "phi_2"} & set(unknown) or not -nu < phi < nu:
        lines.append("# phi: not identifiable from these runs; the distal links are assumed")
        mass, inertia = nominal.distal_mass, nominal.distal_inertia
    else:
        lines.append(f"# measured: {_said(found['phi_1'])}")
        mass, inertia = 2 * (nu + phi), bar.distal**2 * (nu - phi) / 2
    side = (values[0] + values[1]) / 2 - nu * bar.proximal**2 - _rotor(found)
    tip = values[2] - 2 * nu
    if side <= 0.0 or tip < 0.0:
        return [
            "# J and M are smaller than the published links alone; all inertia is assumed",
        ]
    return [
        *lines,
        f"distal_mass: {mass:.6g}   # kg; m/4 + I/L^2 is assumed, no motion tells it apart",
        f"distal_inertia: {inertia:.6g}",
        f"# measured: {_said(found['J_1'])}" + ("" if found.alike else f", {_said(found['J_2'])}"),
        f"proximal_inertia: {side:.6g}   # kg.m2, without the rotor's and the distal link's part",
        f"# measured: {_said(found['M'])}",
        f"tip_mass: {tip:.6g}   # kg, without the distal links' part",
    ]


def _rotor(found: Identified) -> float:
    """What the model adds to a proximal link by itself (kg.m2)."""
    from fmus.shared.mechanism.device import DEVICE, presets

    at = min(next(item.value for item in DEVICE.items if item.name == found.described.preset), 1)
    table = presets("DYNAMICS")
    return table["gear_ratio"][at] ** 2 * table["rotor_inertia"][at]


def _rest(found: Identified) -> list[str]:
    lines: list[str] = []
    for kind, parameter, unit in (
        ("coulomb", "coulomb_friction", "N.m"),
        ("viscous", "viscous_friction", "N.m.s/rad"),
    ):
        pair = [found[f"{kind}_{joint}"] for joint in (1, 2)]
        known = [each.value for each in pair if each.value is not None]
        said = f"# measured: {_said(pair[0])}, {_said(pair[1])}"
        if len(known) == 2:
            lines += [
                said,
                f"{parameter}: {sum(known) / 2:.6g}   # {unit}, the mean of both joints",
            ]
        else:
            lines += [said, f"# {parameter}: assumed"]
    latency, tick = found["latency"], found.runs[0].tick
    if latency.value is not None and latency.value >= 0.0:
        lines += [
            f"# measured: {_said(latency)}; of {tick * 1e3:.4g} ms a tick, in whole ticks",
            f"computation_delay_ticks: {round(latency.value / tick)}",
        ]
    offsets = [found[f"offset_{joint}"] for joint in (1, 2)]
    values = [each.value for each in offsets]
    if None not in values:
        lines += [
            f"# measured: {_said(offsets[0])}, {_said(offsets[1])}",
            f"encoder_bias: [{values[0]:.6g}, {values[1]:.6g}]   # rad, this homing's",
        ]
    return lines


def _comments(found: Identified) -> list[str]:
    """What the model has no parameter for."""
    return [
        "# no parameter of the model: "
        f"{_said(found[name])}"
        + ("; multiply the device file's torque_constant by it" if name.startswith("gain") else "")
        for name in ("gain_1", "gain_2", "bias_1", "bias_2")
    ]


def _said(each: Estimate) -> str:
    if each.low is None or each.high is None:
        return f"{each.name} not identifiable ({each.reason})"
    interval = f"({each.low:.4g} to {each.high:.4g}) {each.unit}"
    if each.value is None:
        return f"{each.name} not identifiable {interval}"
    return f"{each.name} {each.value:.5g} {interval}"
