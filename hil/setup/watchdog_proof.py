"""Seeing a board's watchdog fire: feed it at zero torque, fall silent, wait for its report.

A watchdog that was only configured protects nobody. It is proved once for each device, and the date
and the serial number go into the device file.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime
from typing import final

from hil.device.contract import ZERO, State, WatchdogProof
from hil.device.errors import ActivationRefused, BoardError, DeviceError
from hil.device.lifecycle import Lifecycle

FED_TIMEOUTS = 2.0
"""How long it is fed first, in its own timeouts: a watchdog that fires then is of no use."""
SETTLE_EXCHANGES = 4
"""Exchanges in which an answer may still tell of the time before."""
REPORT_SECONDS = 0.030
"""What a report may take beyond the timeout: heartbeats come every 10 ms."""


class WatchdogProving(Lifecycle):
    """The bench test behind ``cohaptic device check --enable-output``."""

    @final
    def prove_watchdog(self) -> WatchdogProof:
        """Let the board's watchdog fire, with its output stage on and at zero torque.

        Raises:
            ActivationRefused: nobody has allowed the output.
            DeviceError: there is no watchdog, it fires while it is fed, or it does not report in
                time that it has fired.
        """
        self._expect("prove_watchdog", State.INACTIVE)
        timeout = self.watchdog.timeout
        if timeout is None:
            raise DeviceError(f"{self.name} has no watchdog that could be proved")
        if self.permission is None:
            raise ActivationRefused(
                f"the watchdog of {self.name} is proved with its output stage on: give "
                "--enable-output and confirm"
            )
        try:
            self._enter()
            self._feed(timeout)
            seconds = self._starve(timeout)
        finally:
            self._guard(self._send_zero)
            self._guard(self._leave)
        return WatchdogProof(
            date=datetime.now(UTC).date().isoformat(),
            timeout=timeout,
            fired_after=round(seconds, 4),
            serial=self._serial() or self.file.serial,
        )

    @final
    def _feed(self, timeout: float) -> None:
        reports = self.watchdog_reports
        ticks = SETTLE_EXCHANGES + round(FED_TIMEOUTS * timeout / self.tick)
        for count in range(ticks):
            self._send(0, ZERO)
            self.pause()
            self._receive()
            if count < SETTLE_EXCHANGES:
                reports = self.watchdog_reports
            elif self.watchdog_reports > reports:
                raise DeviceError(
                    f"the watchdog of {self.name} fires while it is fed: its timeout is not the "
                    f"{timeout * 1e3:.0f} ms of the device file, or this machine was too busy to "
                    "feed it; try again"
                )

    @final
    def _starve(self, timeout: float) -> float:
        """Listen, send nothing; the time (s) until the report, or until the board was asked."""
        before = self.watchdog_reports
        elapsed = self._stopwatch()
        while (seconds := elapsed()) < timeout + REPORT_SECONDS:
            self.pause()
            with suppress(BoardError):  # the report itself
                self._receive()
            if self.watchdog_reports > before:
                return seconds
        # A board that speaks only when it is spoken to tells what happened meanwhile.
        for _ in range(SETTLE_EXCHANGES):
            self._send(0, ZERO)
            self.pause()
            with suppress(BoardError):
                self._receive()
            if self.watchdog_reports > before:
                return seconds
        raise DeviceError(
            f"the watchdog of {self.name} did not fire within {seconds * 1e3:.0f} ms of silence, "
            f"though its timeout is {timeout * 1e3:.0f} ms: nothing would stop its motors; check "
            "the device's own configuration"
        )

    def _stopwatch(self) -> Callable[[], float]:
        """Seconds since now; in lock-step the board's own time, a tick each time it is asked."""
        if not (self.lockstep or self.in_process):
            begun = time.monotonic()
            return lambda: time.monotonic() - begun
        ticks = iter(range(1_000_000))
        return lambda: next(ticks) * self.tick
