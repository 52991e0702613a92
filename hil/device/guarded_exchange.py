"""The exchange with a board on paths that must go on: what fails becomes FAULT, never an exception.

Everything that brings a device to zero goes through here.
"""

from __future__ import annotations

from hil.device.board_exchange import FIRST_SAMPLE_TRIES, BoardExchange
from hil.device.contract import Flag, State
from hil.device.errors import DeviceError
from hil.device.fault_latch import SETTLE_TICKS
from hil.device.judge import Judge
from hil.device.life import Life
from hil.safety.linkage import Pair


class GuardedExchange:
    """What one device says to its board and hears from it, judged."""

    def __init__(self, exchange: BoardExchange, judge: Judge, life: Life) -> None:
        self.exchange, self.judge, self.life = exchange, judge, life
        self.driver = exchange.driver

    def take(self) -> bool:
        """Receive, and judge what came; whether there was a new valid sample."""
        life = self.life
        try:
            received = self.exchange.receive()
        except Exception as error:
            life.trip_on(error)
            return False
        if life.state is not State.FAULT:
            trip = self.judge.verdict(received, life.state)
            if trip is not None:
                life.trip(trip)
        if received.zero_confirmed:
            life.latch.confirm()
        return received.sample is not None

    def send(self, torque: Pair) -> Flag:
        """A torque, where the device may push."""
        try:
            return Flag.NONE if self.exchange.send(torque) else Flag.NOT_SENT
        except Exception as error:  # whatever fails here must end in zero and FAULT
            self.life.trip_on(error)
            return Flag.NONE

    def send_zero(self) -> bool:
        """Whether a zero went out, or is known to be there."""
        try:
            return self.exchange.send_zero()
        except Exception as error:
            self.life.trip_on(error)
            return False

    def write_zero(self) -> Flag:
        """A tick's zero; in FAULT it is one more towards its outcome."""
        sent = self.send_zero()
        if self.life.state is State.FAULT:
            driver = self.driver
            self.life.latch.settle(driver.watchdog, in_process=driver.in_process)
        return Flag.NONE if sent else Flag.NOT_SENT

    def zero_until_confirmed(self, ticks: int = SETTLE_TICKS) -> bool:
        """Zeros until an answer confirms one, for at most so many ticks; whether one did."""
        before = self.exchange.zeros
        for _ in range(ticks):
            self.send_zero()
            self.driver.pause()
            self.take()
            if self.exchange.zeros > before:
                return True
        return False

    def zero_after_death(self, *, torn: bool) -> bool:
        """The same in another process than the one that died, ``torn``: while writing a frame."""
        try:
            self.driver.take_over()
            if torn:
                self.driver.recover()
            if self.zero_until_confirmed():
                return True
            self.driver.recover()
            return self.zero_until_confirmed(2 * SETTLE_TICKS)
        except Exception:  # the answer is "not confirmed", whatever went wrong
            return False

    def wait_for_sample(self) -> None:
        """Zeros until there is a sample.

        Raises:
            DeviceError: none comes, or what comes ends in FAULT.
        """
        for _ in range(FIRST_SAMPLE_TRIES):
            self.send_zero()
            self.driver.pause()
            if self.take():
                return
            if self.life.state is State.FAULT:
                break
        name, latch = self.driver.name, self.life.latch
        raise DeviceError(
            f"{name} does not answer"
            if latch.fault is None
            else latch.sentence(name, self.driver.watchdog)
        )
