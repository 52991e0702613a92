"""What the supervisor does with a device whose control loop died at any place in a frame."""

from __future__ import annotations

from typing import final

from hil.device.contract import State
from hil.device.fault_latch import SETTLE_TICKS, FaultLatch


class AfterDeath(FaultLatch):
    """Called in the supervisor, which shares nothing with the loop but the open port."""

    @final
    def zero_after_death(self, *, torn: bool) -> bool:
        """Send zero until an answer confirms it; whether one did.

        ``torn`` says that the loop died while it was writing a frame.
        """
        before = self.zeros_confirmed
        try:
            self._take_over()
            if torn:
                self._recover()
            for attempt in range(3 * SETTLE_TICKS):
                self._guard(self._send_zero)
                self.pause()
                self._guard(self._receive)
                if self.zeros_confirmed > before:
                    return True
                if attempt == SETTLE_TICKS:
                    self._recover()
        except Exception:  # the answer is "not confirmed", whatever went wrong
            return False
        return False

    @final
    def release(self) -> None:
        """Let go of the port without a word on the wire (the supervisor has zeroed it)."""
        self._guard(self._close)
        self.state, self.homed = State.UNCONFIGURED, False
