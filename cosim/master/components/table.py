"""A component that is a table in a file: its columns are the outputs, shown over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path

from cosim.base.component import Causality, Cells, Component, Played, Setup, Variable
from cosim.base.document.table_file import TableFile, read_table
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent


class ColumnsOfFile(Component):
    """The columns of a file as outputs, in the units of the heading.

    What is shown follows from the tick: the loop does it, and there is nothing to save.
    """

    feedthrough = False

    def __init__(self, table: TableFile, *, is_linear: bool, time_offset: Fraction) -> None:
        self._table = table
        self._played = Played(table.times + float(time_offset), table.values, is_linear)

    @property
    def variables(self) -> Sequence[Variable]:
        """The columns."""
        return [
            Variable(name=name, causality=Causality.OUTPUT, unit=unit or None)
            for name, unit in zip(self._table.names, self._table.units, strict=True)
        ]

    @property
    def played(self) -> Played:
        """The rows of the file."""
        return self._played

    def initialise(
        self, setup: Setup, inputs: Mapping[str, Cells], outputs: Mapping[str, Cells]
    ) -> None:
        """Nothing: the rows are there."""

    def save(self) -> None:
        """Nothing: what it shows follows from the tick."""

    def load(self, values: None) -> None:
        """Nothing to load."""


def table_of(written: ScenarioComponent, scenario: Scenario) -> ColumnsOfFile:
    """The component of a scenario's ``table``.

    Raises:
        InputError: the file is no such table, with the place of what is wrong; or nothing of it
            lies within the run.
    """
    options = written.options
    table = read_table(Path(written.source), options["columns"])
    _check_span(table, options["time_offset"], scenario)
    return ColumnsOfFile(
        table, is_linear=options["interpolate"] == "linear", time_offset=options["time_offset"]
    )


def _check_span(table: TableFile, offset: Fraction, scenario: Scenario) -> None:
    """Refuse several rows of which a run would show one."""
    first, last = (float(table.times[row]) + float(offset) for row in (0, -1))
    begin = float(scenario.start_tick / scenario.base_rate)
    end = float((scenario.start_tick + scenario.ticks) / scenario.base_rate)
    if len(table.times) > 1 and (last <= begin or first >= end):
        raise InputError(
            f"its times, from {first:g} s to {last:g} s, lie outside the run, from {begin:g} s to "
            f"{end:g} s, which would show one row alone; time_offset moves them."
        )
