"""Seeing a board's watchdog fire: feed it at zero torque, fall silent, wait for its report.

A watchdog that was only configured protects nobody. It is proved once for each device, and the date
and the serial number go into the device file.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime

from hil.device.contract import LONGEST_WATCHDOG, Received, State, WatchdogProof
from hil.device.device import Device
from hil.device.driver import Driver
from hil.device.errors import ActivationRefused, DeviceError, LifecycleError

FED_TIMEOUTS = 2.0
"""How long it is fed first, in its own timeouts: a watchdog that fires then is of no use."""
SETTLE_EXCHANGES = 4
"""Exchanges in which an answer may still tell of the time before."""
ATTEMPTS = 3
REPORT_SECONDS = 0.030
"""What a report may take beyond the timeout: heartbeats come every 10 ms."""


def prove_at_opening(device: Device) -> None:
    """Let the watchdog of a device that may push fire, at zero torque, before it gets any force.

    Nothing in a file and nothing that was true yesterday says that it will today. A machine too
    busy to feed it gets some more attempts.

    Raises:
        DeviceError: it does not fire, or fires while it is fed.
    """
    timeout = device.watchdog.timeout
    if device.permission is None or device.in_process or timeout is None:
        return
    if timeout > LONGEST_WATCHDOG or not device.driver.shares_port:
        return  # no watchdog worth the name; or a maker's driver, which has proved it by itself
    for attempt in range(ATTEMPTS):
        try:
            prove_watchdog(device)
        except WatchdogTooEarly:
            if attempt == ATTEMPTS - 1:
                raise
        else:
            return


class WatchdogTooEarly(DeviceError):
    """A watchdog fired while it was fed."""


def prove_watchdog(device: Device) -> WatchdogProof:
    """Let a board's watchdog fire, with its output stage on and at zero torque.

    Raises:
        ActivationRefused: nobody has allowed the output.
        DeviceError: there is no watchdog, it fires while it is fed, or it does not report in time
            that it has fired.
    """
    if device.state is not State.INACTIVE:
        raise LifecycleError(f"{device.name} is {device.state}, it would have to be inactive")
    driver, timeout = device.driver, device.watchdog.timeout
    if timeout is None:
        raise DeviceError(f"{device.name} has no watchdog that could be proved")
    if device.permission is None:
        raise ActivationRefused(
            f"the watchdog of {device.name} is proved with its output stage on: give "
            "--enable-output and confirm"
        )
    try:
        driver.enter()
        _feed(driver, timeout)
        seconds = _starve(driver, timeout)
    finally:
        for call in (driver.send_zero, driver.leave):
            with suppress(DeviceError):
                call()
    driver.watchdog_seen = timeout
    return WatchdogProof(
        date=datetime.now(UTC).date().isoformat(),
        timeout=timeout,
        fired_after=round(seconds, 4),
        serial=driver.serial() or device.file.serial,
    )


def _feed(driver: Driver, timeout: float) -> None:
    for count in range(SETTLE_EXCHANGES + round(FED_TIMEOUTS * timeout / driver.tick)):
        received = _exchange(driver)
        if count < SETTLE_EXCHANGES:
            continue
        if received.watchdog_fired:
            raise WatchdogTooEarly(
                f"the watchdog of {driver.name} fires while it is fed: its timeout is not the "
                f"{timeout * 1e3:.0f} ms of the device file, or this machine was too busy to "
                "feed it; try again"
            )
        if received.error is not None:
            raise received.error


def _starve(driver: Driver, timeout: float) -> float:
    """Listen, send nothing; the time (s) until the report, or until the board was asked."""
    elapsed = _stopwatch(driver)
    while (seconds := elapsed()) < timeout + REPORT_SECONDS:
        driver.pause()
        if driver.receive().watchdog_fired:  # an error besides is the very report
            return seconds
    # A board that speaks only when it is spoken to tells what happened meanwhile.
    for _ in range(SETTLE_EXCHANGES):
        if _exchange(driver).watchdog_fired:
            return seconds
    raise DeviceError(
        f"the watchdog of {driver.name} did not fire within {seconds * 1e3:.0f} ms of silence, "
        f"though its timeout is {timeout * 1e3:.0f} ms: nothing would stop its motors; check "
        "the device's own configuration"
    )


def _exchange(driver: Driver) -> Received:
    driver.feed()
    driver.pause()
    return driver.receive()


def _stopwatch(driver: Driver) -> Callable[[], float]:
    """Seconds since now; in lock-step the board's own time, a tick each time it is asked."""
    if not (driver.lockstep or driver.in_process):
        begun = time.monotonic()
        return lambda: time.monotonic() - begun
    ticks = iter(range(1_000_000))
    return lambda: next(ticks) * driver.tick
