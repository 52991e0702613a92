"""Everything about an FMU that is known without running it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.component import Variable
from cosim.base.errors import InputError
from cosim.base.quantities.units import Unit
from cosim.master.components.clocks import (
    MOST_CLOCKS,
    ClockFacts,
    EventFacts,
    check_membership,
    clock_facts,
    clock_variables,
)
from cosim.master.components.interface import Interface


@dataclass(frozen=True, slots=True, kw_only=True)
class FmuDescription:
    """Everything about an FMU that is known without running it."""

    path: Path
    folder: Path
    sha256: str
    version: int
    model_identifier: str
    token: str
    variables: Mapping[str, Variable]
    references: Mapping[str, int]
    """Value reference by variable name."""
    dimensions: Mapping[str, tuple[str | None, ...]]
    """For each array, the structural parameter behind each dimension."""
    dependencies: Mapping[str, tuple[str, ...]]
    initial_dependencies: Mapping[str, tuple[str, ...]]
    terminals: Mapping[str, Mapping[str, str]]
    units: Mapping[str, Unit]
    log_categories: tuple[str, ...]
    varies_step: bool
    """Whether its steps may have any length."""
    fixed_step: Fraction | None
    """The step (s) that an FMU which cannot vary its step was made for."""
    step_size: Fraction | None
    """The step (s) that the FMU suggests, by its default experiment or its own steps."""
    start_time: Fraction | None
    """When its default experiment begins (s)."""
    stop_time: Fraction | None
    """When its default experiment ends (s)."""
    calculated: tuple[str, ...]
    """Outputs and local variables whose first value the FMU computes (``initial``)."""
    once_per_process: bool
    breaks: tuple[str, ...]
    """Rules of the standard that the description breaks, and with which it can be used."""
    skipped: Mapping[str, str]
    """The clocked variables, which have values in event mode alone, and their causality."""
    has_event_mode: bool
    clocks: list[dict[str, Any]]
    """The clocks, as ``read_clocks`` found them."""
    at_events: tuple[Variable, ...]
    """Numbers that belong to clocks."""
    clocked: Mapping[str, tuple[str, ...]]
    """The clocks of each clocked variable."""
    at_start: tuple[str, ...]
    """The clocked variables that have a value in initialisation mode."""
    events: EventFacts | None
    """What to do at events, where event mode is used."""
    needs_tool: bool
    """Whether its library only talks to a tool that has to be installed."""
    saves_state: bool
    """Whether it offers its whole state as bytes, and takes it back."""

    def interface(self, component: str, *, feedthrough: bool) -> Interface:
        """The FMU as a component of that name."""
        return Interface(
            component=component,
            variables=self.variables,
            feedthrough=feedthrough,
            dependencies=self.dependencies,
            initial_dependencies=self.initial_dependencies,
            terminals=self.terminals,
            units=self.units,
            skipped=frozenset(self.skipped),
            events=self.events,
        )

    def in_mode(self, wanted: bool | None) -> FmuDescription:
        """With its event mode in use, where it is wanted; by default where there are clocks.

        Then clocks and what belongs to them are among the variables.

        Raises:
            InputError: a clock's ticks do not follow from what it says, or there are too many.
        """
        if not (self.has_event_mode and (bool(self.clocks) if wanted is None else wanted)):
            return self
        try:
            clocks = self._clocks()
        except InputError as error:
            raise InputError(
                f"the FMU {self.path.name}: {error.message}; 'event_mode: false' leaves its clocks "
                "out"
            ) from None
        clocked = {each.name: each for each in self.at_events}
        variables = {**self.variables, **clocked}
        variables |= {each.name: each for each in clock_variables(clocks)}
        own = [name for name in variables if name not in self.variables]
        return replace(
            self,
            variables=variables,
            references={**self.references, **dict.fromkeys(set(own) - set(self.references), 0)},
            dependencies={**self.dependencies, **dict.fromkeys(own, ())},
            initial_dependencies={**self.initial_dependencies, **dict.fromkeys(own, ())},
            skipped={name: why for name, why in self.skipped.items() if name not in variables},
            events=EventFacts(
                clocks=clocks,
                clocked={name: self.clocked[name] for name in clocked},
                at_start=frozenset(self.at_start),
                may_return=self.varies_step,
            ),
        )

    def _clocks(self) -> tuple[ClockFacts, ...]:
        clocks = tuple(clock_facts(written, self.references) for written in self.clocks)
        if len(clocks) > MOST_CLOCKS:
            raise InputError(f"it has {len(clocks)} clocks; up to {MOST_CLOCKS} are driven")
        check_membership(clocks, self.clocked)
        return clocks
