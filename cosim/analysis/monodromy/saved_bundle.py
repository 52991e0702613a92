"""One bundle of a run: what it holds and what flies, put back with other numbers and fates."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.chance.fate import PeriodFate
from cosim.master.assembly.wiring import PacketFact
from cosim.master.channels.packets import NEVER
from cosim.master.run.simulation import Simulation

Real = NDArray[np.float64]

FAR = 1 << 40
"""Ticks after which a packet that does not arrive would: beyond every hyperperiod."""
_ARRIVAL, _SAMPLED = 0, 2
"""Rows of a bundle's flight."""


class SavedBundle:
    """A bundle at the start of the hyperperiod."""

    def __init__(self, simulation: Simulation, number: int) -> None:
        self.number = number
        self._program = simulation.program
        self.bundle = simulation.assembly.wiring.bundles[number]
        layout = simulation.assembly.layout
        real = [index for index, entry in enumerate(self.bundle.entries) if entry.is_float]
        self.real = np.array(real, dtype=np.int64)
        whole = [index for index, entry in enumerate(self.bundle.entries) if not entry.is_float]
        self.whole = np.array(whole, dtype=np.int64)
        self.held = layout.held[number] + self.real
        self.held_whole = layout.held[number] + self.whole
        self.delay = int(self._program.packets.structs[number].delay)
        """Of every packet, in the run as it is put back without a fate (ticks)."""
        self._put: tuple[Real, PeriodFate] | None = None
        self.restart()

    def restart(self) -> None:
        """Take what is held and in flight now as the start."""
        self.values, self.arrays = self._program.packets.save(self.number)
        self._put = None

    @property
    def plan(self) -> tuple[int, int, int]:
        """Its period and delay (ticks), and how many values it carries."""
        return self.bundle.period, self.delay, len(self.bundle.entries)

    @property
    def flying(self) -> int:
        """Packets in flight at the start."""
        return int(self.values["in_flight"])

    def numbers(self) -> Real:
        """What is held and in flight now, numbers only: held first, then packet by packet.

        With a fate, a packet that arrived stays in the list until the run as it is would have
        taken it, so that the numbers after are those before moved on by one packet.
        """
        cells = self._program.cells[self.held].view(np.float64)
        if self._put is None or self.flying == 0:
            payload = self._payload()[: self.flying, self.real].view(np.float64)
            return np.concatenate([cells, payload.reshape(-1)])
        before, fate = self._put
        rows = before[self.real.size :].reshape(self.flying, self.real.size)
        arrived = any(age == 0 for _, age in fate.arrivals)
        newest = cells if arrived else self._payload()[-1, self.real].view(np.float64)
        return np.concatenate([cells, rows[1:].reshape(-1), newest])

    def whole_words(self) -> NDArray[np.int64]:
        """The rest of it, and how many packets are on their way."""
        cells = self._program.cells[self.held_whole]
        payload = self._payload()[:, self.whole].reshape(-1)
        return np.concatenate([cells, payload, [int(self._struct.in_flight)]])

    def put(self, numbers: Real, fate: PeriodFate | None) -> None:
        """Be as at the start, with these numbers; ``fate`` says what arrives in this period."""
        arrays = {name: array.copy() for name, array in self.arrays.items()}
        split = self.real.size
        self._program.cells[self.held] = numbers[:split].view(np.int64)
        arrays["payload"][:, self.real] = numbers[split:].reshape(-1, split).view(np.int64)
        values = dict(self.values)
        self._struct.delay = self.delay
        self._put = None
        if fate is not None:
            self._put = (np.array(numbers), fate)
            self._follow(fate, values, arrays)
        self._program.packets.load(self.number, values, arrays)

    def _follow(
        self, fate: PeriodFate, values: dict[str, Any], arrays: dict[str, NDArray[np.int64]]
    ) -> None:
        """Let arrive what a fate says, and nothing else."""
        tick, flight = int(self._program.kernel.tick), arrays["flight"]
        ages = (tick - flight[_SAMPLED]) // self.bundle.period
        flight[_ARRIVAL] = tick + FAR
        self._struct.delay = FAR
        for offset, age in fate.arrivals:
            flight[_ARRIVAL][ages == age] = tick + offset
            if age == 0:
                self._struct.delay = offset
        values["next_arrival"] = int(flight[_ARRIVAL].min()) if flight.size else NEVER
        if fate.held:
            values["sampled"] = tick - fate.held * self.bundle.period
            for row in np.flatnonzero(ages == fate.held):
                self._program.cells[self.held_whole] = arrays["payload"][row, self.whole]

    @property
    def _struct(self) -> Any:
        return self._program.packets.structs[self.number]

    def _payload(self) -> NDArray[np.int64]:
        return self._program.packets.flying(self.number)


def reads_ages(simulation: Simulation) -> bool:
    """Whether a part looks at how old a packet is: a predictor, or an input wired to the age."""
    return any(
        isinstance(wire.source, PacketFact) for wire in simulation.assembly.wiring.wires
    ) or any(
        part.parameters.get("predictor", "hold_last") not in {"hold_last", 0}
        for part in simulation.scenario.components.values()
    )
