"""Rules on opening, owning and hearing a board; its output stage stays off."""

from __future__ import annotations

from cosim.base.errors import CohapticError
from hil.device.device import Device
from hil.safety.limits import TickLimits
from hil.setup.conform.bench import EXCHANGES, ConformBench, idle
from hil.setup.conform.errors import NotConform, NotTried
from hil.setup.conform.rule import ConformRule

CLOCK_TICKS = 200
CLOCK_SHARE = 0.1
"""By how much a board's clock may go faster or slower than the host's over that time."""
LOST_SHARE = 0.01
"""Share of exchanges without a new sample in real time, where the host itself is late at times."""


def _opens_again(bench: ConformBench) -> None:
    told: list[str | None] = []
    for _ in range(2):
        with bench.opened() as device:
            told.append(device.driver.serial())
            if not any(idle(device.driver).sample for _ in range(EXCHANGES)):
                raise NotConform("it was opened and sends no samples")
    if told[0] != told[1]:
        raise NotConform(f"its serial number was {told[0]} and then {told[1]}")


def _zero_at_both_ends(bench: ConformBench) -> None:
    with bench.opened() as device:
        if not any(idle(device.driver).zero_confirmed for _ in range(EXCHANGES)):
            raise NotConform(
                f"no answer confirmed zero torque within {EXCHANGES} exchanges of zero"
            )
    after = bench.truth()
    if after is not None and after["torque"] != [0.0, 0.0]:
        raise NotConform(f"it was closed and still commands {after['torque']} N.m")


def _has_one_owner(bench: ConformBench) -> None:
    if not bench.kind.shares_port:
        raise NotTried("its maker's library decides who may open it")
    with bench.opened() as first:
        idle(first.driver)
        before = bench.truth()
        other = Device(bench.kind, bench.address, bench.file)
        try:
            other.configure()
        except CohapticError:
            after = bench.truth()
            if before is not None and after is not None and before["tick"] != after["tick"]:
                raise NotConform("a second opener spoke before it was refused") from None
            if not any(idle(first.driver).sample for _ in range(EXCHANGES)):
                raise NotConform("a second opener was refused, and the first is cut off") from None
            return
        other.release()
    raise NotConform("it could be opened a second time while it was open")


def _loses_no_sample(bench: ConformBench) -> None:
    with bench.opened() as device:
        driver = device.driver
        for _ in range(EXCHANGES):
            idle(driver)
        exchanges = round(bench.seconds / driver.tick)
        longest = gap = lost = 0
        allowed = driver.native_period_ticks - 1
        for _ in range(exchanges):
            if idle(driver).sample is not None:
                gap = 0
                continue
            gap += 1
            lost += gap > allowed
            longest = max(longest, gap)
        hold = TickLimits.at(driver.tick).hold
        share = 0.0 if driver.lockstep or driver.in_process else LOST_SHARE
        if longest > max(allowed, hold if share else 0) or lost > share * exchanges:
            raise NotConform(
                f"{lost} of {exchanges} exchanges brought no new sample, {longest} in a row"
            )


def _clock_keeps_time(bench: ConformBench) -> None:
    with bench.opened() as device:
        driver = device.driver
        first = last = None
        ticks = since = 0
        for _ in range(CLOCK_TICKS):
            now = idle(driver).device_time
            ticks += 1
            if now is None:
                continue
            if last is not None and now < last:
                raise NotConform(f"its clock ran back from {last:.4f} to {now:.4f} s")
            first, since = (now, ticks) if first is None else (first, since)
            last = now
        if first is None or last is None:
            raise NotTried("it tells no time of its own")
        passed, expected = last - first, (ticks - since) * driver.tick
        slowest = (1 - CLOCK_SHARE) * expected
        fastest = (1 + CLOCK_SHARE) * expected
        if passed < slowest or (driver.lockstep and passed > fastest):
            raise NotConform(f"its clock went on by {passed:.4f} s in {expected:.4f} s")


LINE_RULES = (
    ConformRule("opens", "It answers at two openings, with one serial number.", _opens_again),
    ConformRule("zero", "It is at zero when opened and when closed.", _zero_at_both_ends),
    ConformRule("owner", "Nobody opens it a second time.", _has_one_owner),
    ConformRule("samples", "Every exchange brings a new sample.", _loses_no_sample),
    ConformRule("clock", "Its clock, if it tells one, keeps time.", _clock_keeps_time),
)
