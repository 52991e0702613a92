"""What every driver is told of its place in a run, whether its board pushes or only measures."""

from __future__ import annotations

import time
from fractions import Fraction

from cosim.base.system.pulse import Pulse
from hil.setup.address import DeviceAddress
from hil.setup.driver_facts import DriverFacts


class BoardDriver(DriverFacts):
    """A driver at an address.

    ``tick`` is the control period (s). ``pulse`` is the supervisor's shared memory, where the board
    is number ``number``; ``None`` without a supervisor.
    """

    def __init__(
        self, address: DeviceAddress, *, tick: Fraction, pulse: Pulse | None, number: int
    ) -> None:
        self.address = address
        self.tick, self.pulse, self.number = float(tick), pulse, number

    @property
    def name(self) -> str:
        """What sentences call it."""
        return self.address.url

    @property
    def lockstep(self) -> bool:
        """Whether it is an emulator that advances exactly as far as it is asked to."""
        return self.address.is_lockstep

    def pause(self) -> None:
        """One tick's time between exchanges outside the loop; none where no clock is involved."""
        if self.pulse is not None:
            self.pulse.beat()
        if not (self.in_process or self.lockstep):
            time.sleep(self.tick)

    def serial(self) -> str | None:
        """The connected board's serial number, ``None`` where it has none to tell."""
        return None
