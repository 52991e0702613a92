"""What measurement cards have in common: counters in, volts out, no port that could be shared."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from hil.device.contract import ZERO, Watchdog
from hil.device.device import Device
from hil.safety.linkage import Pair
from hil.wire.vendor import volts


class CardDevice(Device):
    """Two encoder inputs and two analogue outputs behind a maker's package."""

    shares_port: ClassVar[bool] = False

    _proved: bool = False
    _timeout: float

    @property
    def watchdog(self) -> Watchdog:
        """The card's own, where it has one that was seen to fire at this opening."""
        return Watchdog(timeout=self._timeout if self._proved else None, verified=self._proved)

    def _send(self, tick: int, torque: Pair) -> Pair:
        voltage, given = volts(self.file.joints, torque)
        self._put(voltage)
        return given

    def _send_zero(self) -> None:
        self._put(self._rest)
        self.zeros_confirmed += 1  # the call returns once the card has it

    @property
    def _rest(self) -> Pair:
        """The volts of zero torque."""
        return volts(self.file.joints, ZERO)[0]

    @abstractmethod
    def _put(self, voltage: Pair) -> None:
        """Give the card its volts, which feeds its watchdog."""
