"""One hyperperiod of a run as a function of its state: Φ, from the numbers before to those after.

The state is the live numbers of every FMU, what the channels hold, and what is in flight. Inputs,
outputs and all other cells are computed anew at the hyperperiod's first tick, where everything is
due, so that they are no state.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.chance.fate import PeriodFate
from cosim.analysis.monodromy.saved_bundle import SavedBundle
from cosim.analysis.monodromy.saved_fmu import SavedFmu
from cosim.analysis.monodromy.structure import MapStructure
from cosim.base.errors import InputError
from cosim.master.assembly.wiring import Signal
from cosim.master.run.simulation import Simulation

Real = NDArray[np.float64]

SIGNAL_STEP = 1e-5
"""How far what is held or in flight is moved (SI), unless everything is linear."""


@dataclass(frozen=True, slots=True)
class Coordinate:
    """One number of the state: whose it is, what it is called, its unit and its step (SI)."""

    owner: str
    name: str
    unit: str
    step: float

    def __str__(self) -> str:
        return f"{self.owner}.{self.name}"


class DiscreteChangeError(Exception):
    """A mode, count or undeclared word came out differently because numbers were moved."""


class RunMap:
    """Φ of a run that stands at a multiple of its hyperperiod.

    Args:
        simulation: started, without randomness in its channels, at such a tick above 0.

    Raises:
        InputError: a component does not declare its state, or something else has no derivative.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        self.program = simulation.program
        self.hyperperiod = int(self.program.kernel.hyperperiod)
        self.fmus: dict[str, SavedFmu] = {}
        for name, fmu in simulation.fmus.items():
            self.fmus[name] = _saved(simulation, name, fmu)
        self.is_linear = all(each.declared.is_linear for each in self.fmus.values())
        self.bundles = [
            SavedBundle(simulation, number)
            for number in range(len(simulation.assembly.wiring.bundles))
        ]
        self.structures: dict[tuple[tuple[int, PeriodFate], ...], MapStructure] = {}
        """The structure of its derivatives, or of a run's nearby, by the fates of packets."""
        self.restart()
        if not any(each.declared.live for each in self.fmus.values()):
            raise InputError(
                "The scenario has nothing that moves: its parts follow time alone.",
                simulation.scenario.locate(("components",)),
            )

    def restart(self) -> None:
        """Take where the run stands now as the start."""
        kernel = self.program.kernel
        self.tick, self.phase = int(kernel.tick), int(kernel.phase)
        self.cells = self.program.cells.copy()
        for each in self.fmus.values():
            each.restart()
        for bundle in self.bundles:
            bundle.restart()
        self.coordinates = self._coordinates()
        self.start = np.concatenate(
            [
                *(each.values for each in self.fmus.values()),
                *(bundle.numbers() for bundle in self.bundles),
                np.zeros(0),
            ]
        )
        self.steps = np.array([each.step for each in self.coordinates])

    @property
    def size(self) -> int:
        """How many numbers there are."""
        return len(self.coordinates)

    @property
    def carried(self) -> int:
        """Where the numbers begin that are held or in flight: behind those of the FMUs."""
        return sum(each.start.size for each in self.fmus.values())

    @property
    def seconds(self) -> float:
        """One hyperperiod (s)."""
        return float(self.hyperperiod / self.simulation.scenario.base_rate)

    def undisturbed(
        self, state: Real | None = None, fates: Mapping[int, PeriodFate] | None = None
    ) -> Real:
        """Φ from a state (the start unless given); how it ends is what others are held against."""
        self._put(self.start if state is None else state, fates)
        self._advance()
        numbers = [each.note_end() for each in self.fmus.values()]
        self._whole = [bundle.whole_words() for bundle in self.bundles]
        return np.concatenate([*numbers, *(b.numbers() for b in self.bundles), np.zeros(0)])

    def __call__(self, state: Real, fates: Mapping[int, PeriodFate] | None = None) -> Real:
        """Φ from a state near the undisturbed one.

        Raises:
            DiscreteChangeError: something else than numbers came out differently.
        """
        self._put(state, fates)
        self._advance()
        numbers: list[Real] = []
        for name, each in self.fmus.items():
            found, differs = each.read()
            if differs is not None:
                raise DiscreteChangeError(f"{name}: {differs}")
            numbers.append(found)
        for bundle, whole in zip(self.bundles, self._whole, strict=True):
            if not np.array_equal(bundle.whole_words(), whole):
                raise DiscreteChangeError(f"what {bundle.bundle.name} carries")
            numbers.append(bundle.numbers())
        return np.concatenate([*numbers, np.zeros(0)])

    def numbers(self) -> Real:
        """The numbers that the run has now, at the end of a hyperperiod."""
        found = [each.read()[0] for each in self.fmus.values()]
        return np.concatenate([*found, *(b.numbers() for b in self.bundles), np.zeros(0)])

    def follow(
        self,
        state: Real,
        fates: Mapping[int, PeriodFate] | None = None,
        *,
        hyperperiods: int = 1,
    ) -> Real:
        """Φ from a state, whatever switches on the way; or Φ(Φ(x))."""
        self._put(state, fates)
        self.simulation.advance(self.tick + hyperperiods * self.hyperperiod)
        return self.numbers()

    def move(self, state: Real) -> None:
        """Take another state as the start, at the same tick."""
        self._put(state, None)
        self.restart()

    def has_plan_of(self, other: RunMap) -> bool:
        """Whether the same parts step, hold and send at the same ticks as in another run."""
        mine, theirs = (
            (
                one.hyperperiod,
                one.cells.size,
                {name: each.words.size for name, each in one.fmus.items()},
                [bundle.plan for bundle in one.bundles],
            )
            for one in (self, other)
        )
        return mine == theirs

    def adopt(self, other: RunMap) -> None:
        """Stand where another run of the same plan does, whose parameters are others."""
        kernel = self.program.kernel
        kernel.tick, kernel.phase = other.tick, other.phase
        self.program.cells[:] = other.cells
        for name, each in self.fmus.items():
            each.adopt(other.fmus[name])
        for bundle, theirs in zip(self.bundles, other.bundles, strict=True):
            self.program.packets.load(bundle.number, theirs.values, theirs.arrays)
        self.structures = dict(other.structures)
        self.restart()

    def output(self, component: str, variable: str) -> float:
        """An output at the state that the run stands in now."""
        saved = self.fmus[component]
        words = np.frombuffer(saved.fmu.states.save(), dtype=np.int64)
        return saved.declared.value(words, variable)

    def put(self, state: Real) -> None:
        """Stand at the start with this state."""
        self._put(state, None)

    def _put(self, state: Real, fates: Mapping[int, PeriodFate] | None) -> None:
        kernel = self.program.kernel
        kernel.tick, kernel.phase = self.tick, self.phase
        self.program.cells[:] = self.cells
        first = 0
        for each in self.fmus.values():
            last = first + each.start.size
            each.put(state[first:last])
            first = last
        for bundle in self.bundles:
            last = first + bundle.real.size * (1 + bundle.flying)
            bundle.put(state[first:last], (fates or {}).get(bundle.number))
            first = last

    def _advance(self) -> None:
        self.simulation.advance(self.tick + self.hyperperiod)

    def _coordinates(self) -> list[Coordinate]:
        found: list[Coordinate] = []
        for name, each in self.fmus.items():
            found += [Coordinate(name, one.path, one.unit, one.step) for one in each.declared.live]
        parts = self.simulation.assembly.parts
        step = 1.0 if self.is_linear else SIGNAL_STEP
        for bundle in self.bundles:
            entries = [bundle.bundle.entries[index].source for index in map(int, bundle.real)]
            places = [
                "held",
                *(f"packet {number + 1} in flight" for number in range(bundle.flying)),
            ]
            for place in places:
                for source in entries:
                    assert isinstance(source, Signal)
                    variable = parts[source.component].interface.variables[source.variable]
                    name = f"{source.component}.{source.variable}[{source.index + 1}], {place}"
                    found.append(Coordinate(bundle.bundle.name, name, variable.unit or "", step))
        return found


def _saved(simulation: Simulation, name: str, fmu: Any) -> SavedFmu:
    place = simulation.scenario.locate(("components", name))
    if not fmu.description.saves_state:
        raise InputError(
            f"The theory of a run moves the state of its parts, and the FMU of {name} does not "
            "give its own away.",
            place,
        )
    try:
        return SavedFmu(fmu)
    except LookupError as error:
        raise InputError(
            f"The theory of a run moves the state of its parts, and cannot for {name}: {error}. "
            "Put a bundled model in its place, or measure the run instead.",
            place,
        ) from None
