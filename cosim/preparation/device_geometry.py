"""Whether a workstation computes with the geometry of the device that it is connected to.

Both turn joint angles into a tip and forces into torques, each with its own link lengths. Where
they differ, the handle is elsewhere than the workstation thinks, and is pushed the wrong way.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import isclose

from cosim.base.document.problems import Problems
from cosim.base.errors import InputError
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import Held, Signal

MEASURED = "joint_angle"
_READER = re.compile(rf"(?P<prefix>.*){MEASURED}(\[\d+\])?")
"""Its name where it is read: of an array, or of one element that FMI 2 has as a variable."""
TOLERANCE = 0.01
"""Relative difference of two lengths that a drawing and a measurement may have."""


@dataclass(frozen=True, slots=True)
class Lengths:
    """What a device file says (m)."""

    proximal_length: float
    distal_length: float
    base_distance: float


def judge_geometry(assembly: Assembly, devices: Mapping[str, Lengths], problems: Problems) -> None:
    """Report every device whose lengths are not those of the workstation that reads its angles."""
    for device, component, prefix in sorted(set(_readers(assembly, devices))):
        with problems.at(("components", device, "device")):
            _compare(assembly, device, devices[device], component, prefix)


def _readers(assembly: Assembly, devices: Mapping[str, Lengths]) -> Iterator[tuple[str, str, str]]:
    """Device, component that reads its joint angles, and what stands before their name there."""
    wiring = assembly.wiring
    for wire in wiring.wires:
        source = wire.source
        if isinstance(source, Held):
            source = wiring.bundles[source.bundle].entries[source.index].source
        if not isinstance(source, Signal) or source.component not in devices:
            continue
        reader = _READER.fullmatch(wire.target.variable)
        if source.variable == MEASURED and reader is not None:
            yield source.component, wire.target.component, reader["prefix"]


def _compare(
    assembly: Assembly, device: str, lengths: Lengths, component: str, prefix: str
) -> None:
    """Refuse lengths that differ.

    Raises:
        InputError: with both numbers, and what to write.
    """
    used = _lengths_used(assembly, component, prefix)
    for name, there in used.items():
        here = getattr(lengths, name)
        if not isclose(here, there, rel_tol=TOLERANCE, abs_tol=1e-4):
            raise InputError(
                f"{device} has {name.replace('_', ' ')} {here * 1e3:g} mm by its device file, and "
                f"{component} computes with {there * 1e3:g} mm: set {component}'s parameters "
                f"{prefix}device or {prefix}{name}"
            )


def _lengths_used(assembly: Assembly, component: str, prefix: str) -> dict[str, float]:
    """The lengths (m) that a component computes with; empty where it has no such parameters."""
    from fmus.shared.mechanism.device import presets

    participant = assembly.participants[component]
    variables = participant.interface.variables

    def value(name: str) -> float | None:
        given = participant.parameters.get(prefix + name)
        if given is not None:
            return float(given[0])
        variable = variables.get(prefix + name)
        return None if variable is None or variable.start is None else float(variable.start)

    preset, known = value("device"), presets("GEOMETRY")
    found: dict[str, float] = {}
    for name in Lengths.__slots__:
        length = value(name)
        if length is not None and length < 0:
            length = known[name][int(preset)] if preset in {0.0, 1.0} else None
        if length is not None:
            found[name] = length
    return found
