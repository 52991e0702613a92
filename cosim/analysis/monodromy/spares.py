"""Simulations that have served, for the next run of the same plan with other values."""

from __future__ import annotations

from cosim.analysis.chance.delays import packet_delays
from cosim.master.assembly.variation import with_values
from cosim.master.run.simulation import Simulation, assemble
from cosim.scenario import Scenario


class Spares:
    """Where a simulation comes from, and where one goes that is not needed for the moment."""

    def __init__(self) -> None:
        self._left: Simulation | None = None

    def started(self, scenario: Scenario) -> Simulation:
        """A simulation at tick 0, whose packets all have the longest delay that they may have.

        Raises:
            InputError: a component refuses its parameters or cannot be loaded.
            RunError: it failed.
        """
        simulation = self._renewed(scenario) or assemble(scenario)
        try:
            for number, bundle in enumerate(simulation.assembly.wiring.bundles):
                packets = packet_delays(bundle.fates.direction, bundle.period)
                if packets is not None and not bundle.fates.is_constant:
                    simulation.program.packets.fix(number, packets.longest)
            simulation.start(
                scenario.ticks + 64 * simulation.assembly.clock.hyperperiod(_periods(scenario))
            )
        except BaseException:
            simulation.close()
            raise
        return simulation

    def take(self, simulation: Simulation) -> None:
        """Keep what another run may begin with, in place of what was kept."""
        self.close()
        self._left = simulation

    def close(self) -> None:
        """Free what is kept."""
        if self._left is not None:
            self._left.close()
            self._left = None

    def _renewed(self, scenario: Scenario) -> Simulation | None:
        """What is kept, made ready for the scenario; None: there is nothing of its plan."""
        if self._left is None:
            return None
        assembly = with_values(self._left.assembly, scenario)
        if assembly is None:
            return None
        simulation, self._left = self._left, None
        try:
            simulation.renew(assembly)
        except BaseException:
            simulation.close()
            raise
        return simulation


def _periods(scenario: Scenario) -> list[int]:
    found = [part.period for part in scenario.components.values()]
    found += [channel.period for channel in scenario.channels.values()]
    found += [link.period for link in scenario.connections if link.period is not None]
    return found
