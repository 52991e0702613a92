"""A component of an earlier run, played back: the outputs that it had, tick by tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from cosim.base.component import Causality, Cells, Component, Role, Setup, Variable, VariableType
from cosim.base.errors import InputError, RunError
from cosim.base.suggest import did_you_mean
from cosim.base.texts import TextCells
from cosim.record.reader import RUN_FILE, open_run
from cosim.record.signals import Values
from cosim.record.texts.journal import JOURNAL_FILE
from cosim.record.texts.recorded import TEXTS_FILE, RecordedText
from cosim.scenario import Kind, Scenario
from cosim.scenario import ScenarioComponent as Written


class Playback(Component):
    """Shows at tick k what the recorded component showed at tick k.

    It has the recorded outputs under their own names, and accepts the inputs that were recorded
    (and ignores them), so that it takes the component's place without changing a connection.
    """

    feedthrough = False

    def __init__(
        self,
        folder: Path,
        component: str,
        terminals: Mapping[str, Mapping[str, str]] = MappingProxyType({}),
    ) -> None:
        """``terminals`` are those of the recorded component, which its record does not have."""
        self._terminals = terminals
        self._folder = folder
        self._variables: list[Variable] = []
        self._words: list[tuple[TextCells, RecordedText]] = []
        self._values: dict[str, tuple[int, NDArray[np.int64]]] = {}
        prefix = f"{component}."
        with open_run(folder) as run:
            self._tick = 1 / run.base_rate
            self._start = run.span[0]
            signals = {name: s for name, s in run.signals.items() if name.startswith(prefix)}
            texts = {name: t for name, t in run.texts.items() if name.startswith(prefix)}
            if not signals and not texts:
                known = {name.partition(".")[0] for name in (*run.signals, *run.texts)}
                raise InputError(
                    f"{folder} has nothing recorded of '{component}'."
                    f"{did_you_mean(component, known)}"
                )
            for name, signal in signals.items():
                column = signal.column
                self._variables.append(
                    Variable(
                        name=name.removeprefix(prefix),
                        type=VariableType.FLOAT64 if column.is_float else VariableType.INT64,
                        causality=(
                            Causality.INPUT if column.causality == "input" else Causality.OUTPUT
                        ),
                        unit=column.unit,
                        description=column.description,
                        # What a device could not measure was recorded as NaN.
                        role=Role.SIMULATION_ONLY if _has_holes(signal.values) else None,
                        meaning=column.meaning,
                        belongs_to=column.belongs_to,
                    )
                )
                if column.causality != "input":
                    values = np.ascontiguousarray(signal.values).view(np.int64)
                    self._values[name.removeprefix(prefix)] = (signal.group.period, values)

            self._texts = {
                name.removeprefix(prefix): text
                for name, text in texts.items()
                if text.column.causality != "input"
            }
            for name, text in texts.items():
                self._variables.append(
                    Variable(
                        name=name.removeprefix(prefix),
                        type=VariableType.BINARY if text.column.is_binary else VariableType.STRING,
                        causality=(
                            Causality.INPUT
                            if text.column.causality == "input"
                            else Causality.OUTPUT
                        ),
                        variability="discrete",
                        description=text.column.description,
                    )
                )

    @property
    def variables(self) -> Sequence[Variable]:
        """The recorded ones."""
        return self._variables

    @property
    def files(self) -> Sequence[Path]:
        """The record that is played, its texts included."""
        return tuple(files_of(self._folder))

    def bind_texts(self, inputs: Mapping[str, TextCells], outputs: Mapping[str, TextCells]) -> None:
        """Keep the outputs' views."""
        self._words = [(outputs[name], text) for name, text in self._texts.items()]

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Take the outputs' cells.

        Raises:
            InputError: the run was recorded with another tick, or from another time on.
        """
        tick = setup.tick[0] / setup.tick[1]
        if tick != float(self._tick):
            raise InputError(
                f"{setup.name}: {self._folder} was recorded with a base tick of "
                f"{float(self._tick):g} s; this scenario has {tick:g} s"
            )
        if setup.start_time != self._start:
            raise InputError(
                f"{setup.name}: {self._folder} was recorded from {self._start:.10g} s on and this "
                f"scenario starts at {setup.start_time:.10g} s; it is played tick by tick, so "
                f"write start_time: {self._start:.10g}"
            )
        self._name = setup.name
        self._targets = [
            (outputs[name].view(np.int64), period, values)
            for name, (period, values) in self._values.items()
        ]
        self.evaluate(0)

    @property
    def terminals(self) -> Mapping[str, Mapping[str, str]]:
        """As far as their members were recorded; of an array each element is a member."""
        return {
            name: {
                f"{member}{variable.name.removeprefix(of)}": variable.name
                for member, of in members.items()
                for variable in self._variables
                if variable.name == of or variable.name.startswith(f"{of}[")
            }
            for name, members in self._terminals.items()
        }

    def evaluate(self, tick: int) -> None:
        """Show the recorded row of this tick, or the last one before it.

        Raises:
            RunError: the recording ended before this tick.
        """
        for target, period, values in self._targets:
            row = tick // period
            if row >= len(values):
                raise RunError(
                    f"{self._name}: the recording in {self._folder} ends at tick "
                    f"{len(values) * period}"
                )
            target[0] = values[row]
        for words, text in self._words:
            value = text.at(tick)
            if value is not None:
                words[0] = value

    def save(self) -> None:
        """Nothing: what it shows follows from the tick."""

    def load(self, values: None) -> None:
        """Nothing to load."""


def _has_holes(values: Values) -> bool:
    return values.dtype.kind == "f" and bool(np.isnan(values).any())


def files_of(folder: Path) -> list[Path]:
    """The files of a run's folder that have what it recorded."""
    texts = [folder / name for name in (TEXTS_FILE, JOURNAL_FILE)]
    return [folder / RUN_FILE, *(file for file in texts if file.is_file())]


def play(written: Written) -> Playback:
    """The component that a scenario plays back.

    Raises:
        InputError: its run cannot be read, or has nothing recorded of it.
    """
    played = written.options.get("component") or written.name
    return Playback(Path(written.source), str(played), written.options.get("terminals") or {})


def records_of(scenario: Scenario) -> list[Path]:
    """The records that a scenario plays back."""
    played = (part for part in scenario.components.values() if part.kind is Kind.PLAYBACK)
    return [file for part in played for file in files_of(Path(part.source))]


KINDS = {Kind.PLAYBACK: play}
"""What the record adds to the kinds of components that the master makes itself."""
