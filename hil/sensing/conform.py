"""The rules of the conformance suite that a sensor can keep: there is no output to try."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

from cosim.base.errors import CohapticError
from hil.sensing.sensor import Sensor
from hil.sensing.sensor_driver import SensorDriver
from hil.sensing.sensor_file import SensorFile
from hil.setup.address import DeviceAddress
from hil.setup.conform.errors import NotConform, NotTried
from hil.setup.conform.rule import Conformity, ConformRule, RuleResult
from hil.wire.side_channel import Control

EXCHANGES = 24
LOST_SHARE = 0.01
CLOCK_TICKS, CLOCK_SHARE = 200, 0.1


@dataclass(slots=True, kw_only=True)
class SensorBench:
    """One sensor on one bench; ``control`` is an emulator's side channel."""

    kind: type[SensorDriver]
    address: DeviceAddress
    file: SensorFile
    control: Control | None
    seconds: float
    """How long samples are counted."""

    @contextmanager
    def opened(self) -> Generator[Sensor]:
        """The sensor, open; closed afterwards."""
        sensor = Sensor(self.kind, self.address, self.file)
        sensor.configure()
        try:
            yield sensor
        finally:
            sensor.close()

    def fault(self, kind: str, ticks: int) -> None:
        """Have the emulator spoil so many ticks from now on.

        Raises:
            NotTried: it is no emulator.
        """
        if self.control is None:
            raise NotTried("only an emulator can tell")
        self.control.ask("fault", kind=kind, ticks=ticks)


def _exchange(sensor: Sensor) -> bool:
    """Whether an exchange brought a new sample."""
    sensor.ask()
    sensor.driver.pause()
    sensor.read()
    return sensor.age == 0


def _opens_again(bench: SensorBench) -> None:
    told: list[str | None] = []
    for _ in range(2):
        with bench.opened() as sensor:
            told.append(sensor.driver.serial())
    if told[0] != told[1]:
        raise NotConform(f"its serial number was {told[0]} and then {told[1]}")


def _has_one_owner(bench: SensorBench) -> None:
    with bench.opened() as first:
        try:
            with bench.opened():
                pass
        except CohapticError:
            if not any(_exchange(first) for _ in range(EXCHANGES)):
                raise NotConform("a second opener was refused, and the first is cut off") from None
            return
    raise NotConform("it could be opened a second time while it was open")


def _loses_no_sample(bench: SensorBench) -> None:
    with bench.opened() as sensor:
        exchanges = max(1, round(bench.seconds / sensor.tick))
        lost = sum(not _exchange(sensor) for _ in range(exchanges))
        sensor.raise_fault()
        if lost > (0.0 if sensor.lockstep else LOST_SHARE) * exchanges:
            raise NotConform(f"{lost} of {exchanges} exchanges brought no new sample")


def _clock_keeps_time(bench: SensorBench) -> None:
    with bench.opened() as sensor:
        first = sensor.device_time
        for _ in range(CLOCK_TICKS):
            _exchange(sensor)
        sensor.raise_fault()
        if first is None or sensor.device_time is None:
            raise NotTried("it tells no time of its own")
        passed, expected = sensor.device_time - first, CLOCK_TICKS * sensor.tick
        slowest = (1 - CLOCK_SHARE) * expected
        if passed < slowest or (sensor.lockstep and passed > (1 + CLOCK_SHARE) * expected):
            raise NotConform(f"its clock went on by {passed:.4f} s in {expected:.4f} s")


def _is_noticed(kind: str, words: str) -> ConformRule[SensorBench]:
    def check(bench: SensorBench) -> None:
        with bench.opened() as sensor:
            before = sensor.wrench
            bench.fault(kind, EXCHANGES)
            for _ in range(EXCHANGES):
                _exchange(sensor)
            if sensor.fault is None or sensor.wrench != before:
                raise NotConform(f"{words} ended in no fault, or left a value that means nothing")

    return ConformRule(kind, f"{words.capitalize()} end in a fault, the last value is held.", check)


SENSOR_RULES: tuple[ConformRule[SensorBench], ...] = (
    ConformRule("opens", "It answers at two openings, with one serial number.", _opens_again),
    ConformRule("owner", "Nobody opens it a second time.", _has_one_owner),
    ConformRule("samples", "Every exchange brings a new sample.", _loses_no_sample),
    ConformRule("clock", "Its clock, if it tells one, keeps time.", _clock_keeps_time),
    _is_noticed("corrupt", "damaged answers"),
    _is_noticed("hang", "missing answers"),
    _is_noticed("saturate", "loads beyond its range"),
    _is_noticed("brown-out", "dips of its supply"),
)


def conform_sensor(
    bench: SensorBench, rules: Sequence[ConformRule[SensorBench]] = SENSOR_RULES
) -> Iterator[RuleResult]:
    """What becomes of each rule, as soon as it is known."""
    for rule in rules:
        outcome, sentence = Conformity.KEPT, ""
        try:
            rule.check(bench)
        except NotTried as why:
            outcome, sentence = Conformity.NOT_TRIED, str(why)
        except CohapticError as error:
            outcome, sentence = Conformity.BROKEN, str(error)
        yield RuleResult(rule.name, rule.claim, outcome, sentence)
