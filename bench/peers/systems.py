"""The systems that everybody runs, as parts and joins for masters that know no channels.

Masses (our FMU ``hand``, FMI 2.0) that push one another in a ring or a chain, at one rate or with
every other one at an eighth of it, and the ten FMUs of ``two_users_box``.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from cosim.base.component import VariableType
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import Held, Signal, Source
from cosim.scenario import Scenario, load
from cosim.testing.ring import row_of_masses

SHAPES = ("ring", "chain")
RATE, SLOW = 512, 8
"""Hz, and every how many ticks the slow parts step: libcosim counts whole nanoseconds, of which
1/1024 s is no number, and 1/512 s is one. A tick costs what it costs, however long it is."""
TYPES = {VariableType.FLOAT64: "Real", VariableType.BOOLEAN: "Boolean"}
FINGERS = ("a1", "a2", "b1", "b2")


@dataclass(frozen=True)
class System:
    """What a peer is given as a file of JSON."""

    step: float
    """One tick (s)."""
    ticks: int
    parts: list[dict[str, Any]]
    """Name, path of the FMU, every how many ticks it steps, start: name -> [type, value]."""
    joins: list[list[str]]
    """Part and variable that gives, part and variable that gets, type."""
    watched: list[list[str]]
    """Part, variable, type: what is recorded, and compared at the last tick."""

    def write(self, file: Path) -> Path:
        file.write_text(json.dumps(asdict(self)))
        return file


def masses(shape: str, size: int, ticks: int, folder: Path, *, mixed: bool) -> Scenario:
    """A ring or a chain; ``mixed`` steps the odd masses at the slow rate."""
    rates = {"rate": RATE, "every": SLOW if mixed else 1}
    file = folder / f"{shape}.yaml"
    file.write_text(row_of_masses(size, ticks=ticks, is_closed=shape == "ring", **rates))
    return load(file)


def two_users(ticks: int) -> Scenario:
    """Our own system of FMI 2.0's FMUs, over a network that costs no time, for peers have none."""
    names = [f"{kind}_{finger}" for kind in ("finger", "operator") for finger in FINGERS]
    written = {
        "duration": f"{ticks}/{RATE}",
        "rates.control": f"{RATE} Hz",
        "channels.lan.rate": "control",
        "channels.lan.delay": "{forward: 0, backward: 0}",
        "record": "[finger_*.tip_position*, vr_*.position*]",
        **{f"components.{name}.flavour": "fmi2" for name in (*names, "vr_a", "vr_b")},
    }
    return load("two_users_box", sets=[f"{key}={value}" for key, value in written.items()])


def type_of(assembly: Assembly, part: str, variable: str) -> str:
    """By what name FMI 2.0's functions go."""
    found = assembly.participants[part].interface.variables[variable].type
    return TYPES.get(found, "Integer")


def system_of(assembly: Assembly) -> System:
    """The parts and joins of an assembled scenario of FMUs; where a channel was, a plain join."""
    bundles = assembly.wiring.bundles

    def origin(source: Source) -> Signal:
        if isinstance(source, Held):
            return origin(bundles[source.bundle].entries[source.index].source)
        if not isinstance(source, Signal):
            raise SystemExit("an FMU is told the age of a packet, which no peer has")
        return source

    joins: list[list[str]] = []
    for wire in assembly.wiring.wires:
        if not wire.is_plain:
            raise SystemExit(f"{wire.target} gets another unit, which no peer converts alike")
        source, target = origin(wire.source), wire.target
        kind = type_of(assembly, target.component, target.variable)
        joins.append([source.component, source.variable, target.component, target.variable, kind])
    parts: list[dict[str, Any]] = []
    for name, part in assembly.participants.items():
        if part.fmu is None:
            raise SystemExit(f"{name} is no FMU")
        start: dict[str, list[Any]] = {}
        for variable, (value, *_) in {**part.parameters, **part.start}.items():
            start[variable] = [type_of(assembly, name, variable), value]
        path = str(part.fmu.path)
        parts.append({"name": name, "path": path, "every": part.period, "start": start})
    return System(
        step=float(assembly.clock.tick),
        ticks=assembly.scenario.ticks,
        parts=parts,
        joins=joins,
        watched=[
            [*(name := column.name.split(".", 1)), type_of(assembly, *name)]
            for group in assembly.groups
            for column in group.columns
        ],
    )
