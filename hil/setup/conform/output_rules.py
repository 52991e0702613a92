"""Rules that are tried with the output stage on, at zero torque or next to it."""

from __future__ import annotations

from math import ceil, floor, inf, nan, sin

from hil.device.contract import ZERO, State
from hil.device.driver import Driver
from hil.setup.conform.bench import EXCHANGES, ConformBench, fed, idle, silent
from hil.setup.conform.errors import NotConform, NotTried
from hil.setup.conform.rule import ConformRule, Need

TINY = (0.008, -0.004)
"""Torques (N.m) that are below a tenth of any limit and above any rounding."""
SWING, SWING_TICKS = 0.02, 700
"""A torque (N.m) to and fro, for so long, that moves a handle by more than its counts."""
LONGEST_LATENCY = 5
RESTART_TICKS = 100
OUTPUT = frozenset({Need.OUTPUT})


def _says_that_it_is_on(bench: ConformBench) -> None:
    with bench.opened() as device:
        driver = device.driver
        if any(idle(driver).enabled for _ in range(EXCHANGES)):
            raise NotConform("it says that its output stage is on, though it was never entered")
        driver.enter()
        told = [fed(driver).enabled for _ in range(EXCHANGES)]
        if any(each is not None for each in told) and not told[-1]:
            raise NotConform("it was entered, and says that its output stage is off")


def _torque_arrives(bench: ConformBench) -> None:
    with bench.active() as device:
        device.read(0)
        sent = device.write(0, ZERO)
        for tick in range(1, 2 * round(device.file.limits.ramp_time / device.tick)):
            device.read(tick)
            sent = device.write(tick, TINY)
        truth = bench.truth()
        assert truth is not None, "the rule needs an emulator"
        for joint, drive in enumerate(joint.drive for joint in device.file.joints):
            wanted = drive.direction * sent.torque[joint] / drive.gear
            if abs(truth["torque"][joint] - wanted) > 1e-3 * abs(wanted) + 2e-6:
                raise NotConform(
                    f"{wanted:.4g} N.m were sent to motor {joint + 1}, and its board commands "
                    f"{truth['torque'][joint]:.4g}"
                )


def _latency_is_as_declared(bench: ConformBench) -> None:
    """The lag at which what is measured fits best to what the emulated handle does."""
    with bench.opened() as device:
        driver, joint = device.driver, device.file.joints[0]
        if not device.lockstep:
            raise NotTried("an emulator in real time answers when it may; emulate with --lockstep")
        driver.enter()
        measured: list[float] = []
        true: list[float] = []
        latest = 0.0
        for tick in range(SWING_TICKS):
            sample, truth = driver.receive().sample, bench.truth()
            if sample is not None:
                latest = joint.direction * sample.shaft_angle[0]
            assert truth is not None, "the rule needs an emulator"
            measured.append(latest)
            true.append(truth["angle"][0])
            driver.send((SWING * sin(tick / 20), 0.0))
        driver.send_zero()
    found = min(range(LONGEST_LATENCY), key=lambda lag: _misfit(measured, true, lag))
    declared = bench.kind.latency_of(bench.address)
    if found != declared:
        raise NotConform(f"what is measured is {found} ticks old, and latency_ticks is {declared}")


def _misfit(measured: list[float], true: list[float], lag: int) -> float:
    """The variance of what a delay by ``lag`` ticks leaves unexplained (rad^2)."""
    start = EXCHANGES
    left = [m - t for m, t in zip(measured[start:], true[start - lag :], strict=False)]
    middle = sum(left) / len(left)
    return sum((each - middle) ** 2 for each in left) / len(left)


def _no_number_is_no_torque(bench: ConformBench) -> None:
    if not bench.kind.checks_frames:
        raise NotTried("its board trusts every byte that it gets: only the host's layer guards it")
    for value in (nan, inf, -inf):
        with bench.opened() as device:
            driver = device.driver
            driver.enter()
            fed(driver)
            try:
                driver.send((value, 0.0))
            except (ValueError, OverflowError):
                continue  # the driver itself has no code for it
            driver.pause()
            told = driver.receive()
            truth = bench.truth()
            obeyed = truth is not None and truth["torque"] != [0.0, 0.0]
            if obeyed or (truth is None and told.sample is not None and not told.zero_confirmed):
                raise NotConform(f"it took a torque of {value} for one")


def _watchdog_fires_in_time(bench: ConformBench) -> None:
    with bench.opened() as device:
        driver, timeout = device.driver, _timeout(bench)
        _armed(driver)
        if _fired(driver, floor(0.5 * timeout / driver.tick)):
            raise NotConform(f"its watchdog of {timeout * 1e3:.0f} ms fired within half that time")
        idle(driver)
        _armed(driver)
        if not _fired(driver, ceil(1.5 * timeout / driver.tick)):
            raise NotConform(
                f"its watchdog of {timeout * 1e3:.0f} ms did not fire in one and a half that time"
            )


def _watchdog_stays_fired(bench: ConformBench) -> None:
    with bench.opened() as device:
        driver, timeout = device.driver, _timeout(bench)
        _armed(driver)
        silent(driver, ceil(2.0 * timeout / driver.tick))
        for _ in range(EXCHANGES):
            driver.send(TINY if bench.control is not None else ZERO)
            driver.pause()
            told = driver.receive()
            truth = bench.truth()
            if told.enabled or (truth is not None and truth["torque"] != [0.0, 0.0]):
                raise NotConform(
                    "its watchdog had fired, and a new command alone had its output stage on again"
                )


def _restart_is_noticed(bench: ConformBench) -> None:
    with bench.active() as device:
        for tick in range(1, EXCHANGES):
            device.read(tick)
            device.write(tick, ZERO)
            device.driver.pause()
        bench.do("Press the board's reset button", "fault", kind="restart", ticks=3)
        for tick in range(EXCHANGES, EXCHANGES + RESTART_TICKS):
            device.read(tick)
            device.write(tick, ZERO)
            device.driver.pause()
        if device.state is not State.FAULT:
            raise NotConform(f"it was reset, and {RESTART_TICKS} ticks later nothing is noticed")


def _timeout(bench: ConformBench) -> float:
    timeout = bench.kind(bench.address, bench.file).watchdog.timeout
    if timeout is None:
        raise NotTried("it has no watchdog: 'estop: confirmed' has to stand for one")
    return timeout


def _armed(driver: Driver) -> None:
    """The output stage on, at zero, and fed."""
    driver.enter()
    told = [fed(driver) for _ in range(EXCHANGES)]
    if told[-1].watchdog_fired:
        raise NotConform("its watchdog fires while it is fed")


def _fired(driver: Driver, ticks: int) -> bool:
    """Whether it fired in so many ticks of silence; asked twice where it speaks only then."""
    heard = [*silent(driver, ticks), fed(driver), fed(driver)]
    return any(each.watchdog_fired for each in heard) or heard[-1].enabled is False


OUTPUT_RULES = (
    ConformRule("enabled", "It tells whether its output stage is on.", _says_that_it_is_on, OUTPUT),
    ConformRule(
        "torque",
        "The torque that was sent is the one it commands.",
        _torque_arrives,
        OUTPUT | {Need.EMULATOR},
    ),
    ConformRule(
        "latency",
        "What is measured is as old as the driver declares.",
        _latency_is_as_declared,
        OUTPUT | {Need.EMULATOR},
    ),
    ConformRule("nan", "What is no number is no torque.", _no_number_is_no_torque, OUTPUT),
    ConformRule(
        "watchdog",
        "Its watchdog fires between 0.5 and 1.5 of its timeout.",
        _watchdog_fires_in_time,
        OUTPUT,
    ),
    ConformRule("rearm", "A watchdog that fired stays so.", _watchdog_stays_fired, OUTPUT),
    ConformRule("reset", "A reset of the board is noticed.", _restart_is_noticed, OUTPUT),
)
