"""What measurement cards have in common: counters in, volts out, no port that could be shared."""

from __future__ import annotations

from abc import abstractmethod
from typing import ClassVar

from hil.device.contract import ZERO, Watchdog
from hil.device.driver import Driver
from hil.device.errors import BoardError
from hil.safety.linkage import Pair
from hil.wire.vendor import volts


class CardDriver(Driver):
    """Two encoder inputs and two analogue outputs behind a maker's package."""

    shares_port: ClassVar[bool] = False
    command_unit = "V"

    _proved: bool = False
    _zero: bool = False
    """Whether zero is what the card was last given."""
    _timeout: float

    @property
    def watchdog(self) -> Watchdog:
        """The card's own, where it has one that was seen to fire at this opening."""
        return Watchdog(timeout=self._timeout if self._proved else None, verified=self._proved)

    def send(self, torque: Pair) -> Pair:
        voltage, given = volts(self.file.joints, torque)
        self._zero = False
        if not self._put(voltage):
            raise BoardError("the card's watchdog has expired")
        self._zero = given == ZERO
        return given

    def send_zero(self) -> bool:
        self._put(self._rest)
        self._zero = True  # the call returns once the card has it
        return True

    @property
    def _rest(self) -> Pair:
        """The volts of zero torque."""
        return volts(self.file.joints, ZERO)[0]

    @abstractmethod
    def _put(self, voltage: Pair) -> bool:
        """Give the card its volts, which feeds its watchdog; whether that had not expired."""
