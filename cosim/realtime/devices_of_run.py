"""The devices of a paced run: who opens which, who is at zero, and what is said of who is not."""

from __future__ import annotations

import time
from collections.abc import Generator, Sequence
from contextlib import suppress

from cosim.base.system.pulse import Pulse, Who
from cosim.base.system.supervised import Opening, Opens, Supervised
from cosim.master.run.simulation import Simulation

UNKNOWN = "output unknown, cut the power: the device may still be pushing"


class DevicesOfRun:
    """Those of one run, by component; a process knows those that were open when it was forked."""

    def __init__(self, simulation: Simulation, pulse: Pulse) -> None:
        self._simulation, self._pulse = simulation, pulse
        self.parts: dict[str, Opens] = {
            name: part.component
            for name, part in simulation.assembly.participants.items()
            if isinstance(part.component, Opens)
        }
        """What opens them."""
        self.open: dict[str, Supervised] = {}
        """Those that are open in this process."""
        self._number = {name: number for number, name in enumerate(self.parts)}

    def open_shared(self) -> None:
        """Open the devices whose ports the other processes can go on with."""
        self._pulse.who = Who.COMMAND
        for _ in self.opening(shared=True):
            pass

    def ask_for_the_rest(self) -> None:
        """What people have to be asked of the devices that the loop opens, where nobody is."""
        for part in self.parts.values():
            if not part.shares_port:
                part.ask()

    def opening(self, *, shared: bool) -> Generator[Supervised]:
        """One by one, so that the caller knows of those that are open when the next one fails."""
        participants, scenario = self._simulation.assembly.participants, self._simulation.scenario
        for name, part in self.parts.items():
            if part.shares_port is shared:
                device = part.open(
                    Opening(
                        name=name,
                        number=self._number[name],
                        tick=participants[name].period / scenario.base_rate,
                        parameters=dict(scenario.components[name].parameters),
                        pulse=self._pulse,
                        clock=time.monotonic,
                    )
                )
                self.open[name] = device
                yield device

    def close_all(self) -> None:
        """Zero the devices that are open here, and let go of them."""
        for device in self.open.values():
            with suppress(Exception):
                device.close()

    def let_go(self) -> None:
        """Of the ports; who had to be zeroed is."""
        for device in self.open.values():
            with suppress(Exception):
                device.release()

    def numbered(self) -> list[tuple[int, Supervised]]:
        """Those that are open here, with their places in the pulse."""
        return [(self._number[name], device) for name, device in self.open.items()]

    def in_order(self) -> Sequence[Supervised]:
        """Every device, as the feed tells of them."""
        return [self.open[name] for name in self.parts]

    @property
    def are_timed(self) -> bool:
        """Whether a clock matters: not with devices in lock-step alone."""
        here = self.open.values()
        apart = len(self.parts) > len(here)
        return apart or not here or any(not device.lockstep for device in here)

    def unsure(self) -> list[str]:
        """What has to be said of devices that nobody saw at zero after their last torque."""
        said: list[str] = []
        for name, number in self._number.items():
            if self._pulse.is_cold(number):
                continue
            device = self.open.get(name)
            if device is None:
                said.append(
                    f"{name} is out of the supervisor's reach; its board's watchdog drops "
                    "the torque"
                )
            elif device.drops_torque:
                said.append(f"{device.name} does not answer; its own watchdog drops the torque")
            elif not device.in_process:
                said.append(f"{device.name}: {UNKNOWN}")
        return said
