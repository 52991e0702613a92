"""A slow loop over FMPy's own Python interface, that the kernel must equal bit for bit.

It shares the reading and the wiring of a scenario with the master, and nothing after that: values
are pulled (an output asks for the inputs it depends on, an input for its source) instead of being
pushed in a planned order, one FMI call a variable, and what a channel holds at tick k is written
down as its definition: of all packets that have arrived by then, the one with the highest number.
FMUs only, and none whose event mode is used.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Causality, VariableType
from cosim.base.errors import InputError
from cosim.master.assembly.assemble import Assembly
from cosim.master.assembly.wiring import Held, PacketFact, Signal, Source, Wire
from cosim.master.channels.fates import LOST
from cosim.master.components.interface import has_cells, size_of
from cosim.master.components.parameters import element_start
from cosim.master.components.participant import Participant

Number = float | int


@dataclass(slots=True)
class _Model:
    """One FMU behind FMPy."""

    participant: Participant
    fmu: Any
    shown: dict[str, list[Number]] = field(default_factory=dict[str, list[Number]])
    known: set[str] = field(default_factory=set[str])
    given: set[str] = field(default_factory=set[str])

    def get(self, variable: str) -> list[Number]:
        kind, references = self._access(variable)
        getter = getattr(self.fmu, f"get{kind}")
        size = size_of(self.participant.interface.variables[variable])
        three = self.participant.fmu is not None and self.participant.fmu.version == 3
        values: list[Number] = (
            getter(references, nValues=size) if three and size > 1 else getter(references)
        )
        is_float = self.participant.interface.variables[variable].type.is_float
        return [float(v) if is_float else int(v) for v in values]

    def set(self, variable: str, values: list[Any]) -> None:
        kind, references = self._access(variable)
        getattr(self.fmu, f"set{kind}")(references, values)

    def _access(self, variable: str) -> tuple[str, list[int]]:
        description = self.participant.fmu
        assert description is not None
        kind = description.variables[variable].type
        if description.version == 2:
            name = {
                VariableType.FLOAT64: "Real",
                VariableType.BOOLEAN: "Boolean",
                VariableType.STRING: "String",
            }.get(kind, "Integer")
        else:
            name = "Int64" if kind is VariableType.ENUMERATION else str(kind)
        return name, [description.references[variable]]


class ReferenceLoop:
    """Runs an assembled scenario of FMUs.

    Raises:
        InputError: a component is no FMU, or is led through event mode.
    """

    def __init__(self, assembly: Assembly) -> None:
        for name, participant in assembly.participants.items():
            if participant.fmu is None:
                raise InputError(f"{name} is no FMU: the reference loop runs FMUs only")
            if participant.fmu.events is not None:
                raise InputError(
                    f"{name} is led through event mode, which the reference loop does not know; "
                    "write 'event_mode: false'"
                )
        self.assembly = assembly
        self.wires: dict[tuple[str, str], list[Wire]] = {}
        for wire in assembly.wiring.wires:
            key = (wire.target.component, wire.target.variable)
            self.wires.setdefault(key, []).append(wire)
        self.models: dict[str, _Model] = {}
        self.packets: list[list[tuple[int, int, list[Number]]]] = []
        """For each bundle and packet number: tick sampled, delay, values."""
        self.fates: list[NDArray[np.int64]] = []
        self.first: list[list[Number]] = []
        self.tick = 0
        self.initialising = False

    def run(self, ticks: int) -> dict[str, NDArray[Any]]:
        """Every recorded signal by name, over ticks 0 … ``ticks`` - 1."""
        try:
            self._start()
            rows: list[list[list[Number]]] = [[] for _ in self.assembly.groups]
            for tick in range(ticks):
                self._one_tick(tick, rows)
            return self._columns(rows)
        finally:
            for model in self.models.values():
                model.fmu.terminate()
                model.fmu.freeInstance()

    def _start(self) -> None:
        for bundle in self.assembly.wiring.bundles:
            self.packets.append([])
            count = -(-self.assembly.scenario.ticks // bundle.period)
            self.fates.append(bundle.fates.begin().take(count)[0])
            self.first.append([])
        for name, participant in self.assembly.participants.items():
            description = participant.fmu
            assert description is not None
            module: Any = importlib.import_module(f"fmpy.fmi{description.version}")
            kind = module.FMU2Slave if description.version == 2 else module.FMU3Slave
            fmu = kind(
                guid=description.token,
                unzipDirectory=str(description.folder),
                modelIdentifier=description.model_identifier,
                instanceName=name,
            )
            fmu.instantiate()
            self.models[name] = model = _Model(participant, fmu)
            for variable, values in {**participant.parameters, **participant.start}.items():
                model.set(variable, values)
            if description.version == 2:
                fmu.setupExperiment(startTime=0.0)
                fmu.enterInitializationMode()
            else:
                fmu.enterInitializationMode(startTime=0.0)
        self.initialising = True
        self._evaluate_all()
        self.initialising = False
        for model in self.models.values():
            model.fmu.exitInitializationMode()

    def _one_tick(self, tick: int, rows: list[list[list[Number]]]) -> None:
        self.tick = tick
        self._evaluate_all()
        for number, bundle in enumerate(self.assembly.wiring.bundles):
            if tick % bundle.period == 0:
                values = [self._value(entry.source) for entry in bundle.entries]
                delay = int(self.fates[number][len(self.packets[number])])
                self.packets[number].append((tick, delay, values))
        for group, described in enumerate(self.assembly.groups):
            if tick % described.period == 0:
                rows[group].append(self._row(group))
        for model in self.models.values():
            part = model.participant
            if tick % part.period == 0:
                self._step(model, part, tick)

    def _step(self, model: _Model, part: Participant, tick: int) -> None:
        clock = self.assembly.clock
        step = clock.step(part.period, part.substeps)
        for i in range(part.substeps):
            exact = (tick + Fraction(i * part.period, part.substeps)) * clock.tick
            model.fmu.doStep(currentCommunicationPoint=float(exact), communicationStepSize=step)

    def _evaluate_all(self) -> None:
        due = [m for m in self.models.values() if self.tick % m.participant.period == 0]
        for model in due:
            model.known.clear()
            model.given.clear()
        for model in due:
            if not model.participant.interface.feedthrough:
                for name in self._readable(model):
                    self._output(model, name)
        for model in due:
            for name in self._readable(model):
                self._output(model, name)
        for model in due:
            for component, variable in self.wires:
                if component == model.participant.name:
                    self._give(model, variable)

    def _readable(self, model: _Model) -> list[str]:
        """Outputs that are numbers; texts are not this loop's."""
        variables = model.participant.interface.variables.values()
        shown = (v for v in variables if v.causality is Causality.OUTPUT and not v.type.is_text)
        return [v.name for v in shown if has_cells(v)]

    def _output(self, model: _Model, name: str) -> list[Number]:
        due = self.tick % model.participant.period == 0
        if due and name not in model.known:
            interface = model.participant.interface
            for variable in interface.outputs_depend_on(name, initially=self.initialising):
                self._give(model, variable)
            model.shown[name] = model.get(name)
            model.known.add(name)
        return model.shown[name]

    def _give(self, model: _Model, variable: str) -> None:
        key = (model.participant.name, variable)
        if key not in self.wires or variable in model.given:
            return
        values = self._input(key)
        model.set(variable, values)
        model.given.add(variable)

    def _input(self, key: tuple[str, str]) -> list[Number]:
        component, variable = key
        participant = self.assembly.participants[component]
        described = participant.interface.variables[variable]
        values: list[Number] = list(participant.start.get(variable) or element_start(described))
        for wire in self.wires.get(key, ()):
            value = self._value(wire.source)
            values[wire.target.index] = (
                value if wire.is_plain else float(value) * wire.gain + wire.offset
            )
        return values

    def _value(self, source: Source) -> Number:
        if isinstance(source, Signal):
            return self._output(self.models[source.component], source.variable)[source.index]
        held = self._held(source.bundle)
        if isinstance(source, PacketFact):
            sampled = held[1] if held is not None else 0
            sequence = held[0] if held is not None else -1
            return self.tick - sampled if source.name == "age" else sequence
        return self._held_value(source, held)

    def _held(self, bundle: int) -> tuple[int, int] | None:
        """Number and tick of the newest packet that has arrived."""
        period = self.assembly.wiring.bundles[bundle].period
        for number in range(self.tick // period, -1, -1):
            delay = int(self.fates[bundle][number])
            if delay != LOST and number * period + delay <= self.tick:
                return number, number * period
        return None

    def _held_value(self, source: Held, held: tuple[int, int] | None) -> Number:
        entry = self.assembly.wiring.bundles[source.bundle].entries[source.index]
        if held is not None and held[1] == self.tick:
            return self._value(entry.source)
        if held is not None:
            return self.packets[source.bundle][held[0]][2][source.index]
        if entry.target is None:
            if self.tick == 0:
                return self._value(entry.source)
            return self.packets[source.bundle][0][2][source.index]
        participant = self.assembly.participants[entry.target.component]
        described = participant.interface.variables[entry.target.variable]
        start = participant.start.get(entry.target.variable) or element_start(described)
        return start[entry.target.index]

    def _row(self, group: int) -> list[Number]:
        row: list[Number] = []
        for column in self.assembly.groups[group].columns:
            component, _, name = column.name.partition(".")
            if component not in self.models:
                row.append(self._value(self._fact(column.name)))
                continue
            model = self.models[component]
            element = model.participant.interface.elements[name]
            variable = model.participant.interface.variables[element.variable]
            if variable.causality is Causality.INPUT:
                row.append(self._input((component, element.variable))[element.index])
            else:
                row.append(self._output(model, element.variable)[element.index])
        return row

    def _fact(self, name: str) -> PacketFact:
        for number, bundle in enumerate(self.assembly.wiring.bundles):
            if bundle.channel is not None and name.startswith(f"{bundle.name}."):
                return PacketFact(number, name.removeprefix(f"{bundle.name}."))
        raise KeyError(name)

    def _columns(self, rows: list[list[list[Number]]]) -> dict[str, NDArray[Any]]:
        columns: dict[str, NDArray[Any]] = {}
        for group, described in enumerate(self.assembly.groups):
            for index, column in enumerate(described.columns):
                kind = np.float64 if column.is_float else np.int64
                columns[column.name] = np.array([row[index] for row in rows[group]], dtype=kind)
        return columns
