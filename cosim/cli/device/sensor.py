"""What the commands on devices do with a sensor, which nobody has to permit anything."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path

    from hil.sensing.look import SensorCheck
    from hil.sensing.reading import Wrench
    from hil.sensing.sensor import Sensor
    from hil.setup.conform.rule import RuleResult

AXES = ("force x", "force y", "force z", "torque x", "torque y", "torque z")


def is_sensor(url: str) -> bool:
    """Whether the driver in a device URL only measures.

    Raises:
        InputError: it is no URL, or there is no such driver.
    """
    from hil.setup.address import parse
    from hil.setup.registry import find

    return find(parse(url).driver).measures_only


def refuse_for_sensor(**given: object) -> None:
    """Refuse options that act on an output.

    Raises:
        InputError: one was given.
    """
    from cosim.base.errors import InputError
    from cosim.cli.support.effect import given_of

    named = given_of({f"--{name.replace('_', '-')}": value for name, value in given.items()})
    if named:
        raise InputError(f"{' and '.join(named)}: a sensor has no output; leave it out.")


def open_sensor(url: str, file: Path | None) -> Sensor:
    """An open sensor; without a file it is what its maker sells.

    Raises:
        DeviceError: it does not answer, or cannot be tared.
        InputError: URL or file cannot be used.
    """
    made = _made(url, file)
    made.configure()
    return made


def _made(url: str, file: Path | None) -> Sensor:
    from hil.sensing.component import sensor_file
    from hil.sensing.sensor import Sensor
    from hil.sensing.sensor_driver import find_sensor
    from hil.setup.address import parse
    from hil.setup.options import check_options

    address = parse(url)
    kind = find_sensor(address.driver)
    check_options(kind.options, address)
    return Sensor(kind, address, sensor_file(kind, {} if file is None else {"file": file}))


def look_at_sensor(url: str, file: Path | None, seconds: float, *, quiet: bool) -> SensorCheck:
    """Look at the sensor at URL, and show its force and torque meanwhile."""
    from hil.sensing.look import check_sensor

    click.echo("Keep the load off the sensor while it is opened.", err=True)
    with open_sensor(url, file) as sensor:
        click.echo(f"Push on {sensor.name}.", err=True)
        return check_sensor(sensor, seconds, None if quiet else _show)


def sentences(seen: SensorCheck) -> str:
    """What a look showed."""
    measured = [
        f"{name} from {low:.4f} to {high:.4f} {'N' if name.startswith('force') else 'N.m'}"
        for name, low, high in zip(AXES, seen.lowest, seen.highest, strict=True)
        if low <= high
    ]
    return (
        f"\n{seen.samples} samples in {seen.exchanges} exchanges, {seen.rate:.0f} a second, oldest "
        f"data {seen.oldest_sample} ticks; one exchange takes {seen.median * 1e6:.0f} µs (median), "
        f"{seen.p99 * 1e6:.0f} (p99), {seen.worst * 1e6:.0f} (worst)\n" + "\n".join(measured)
    )


def rules_of_sensor(
    url: str, file: Path | None, only: Sequence[str], seconds: float
) -> Iterator[RuleResult]:
    """Try a sensor against every rule that it can keep."""
    from hil.sensing.conform import SENSOR_RULES, SensorBench, conform_sensor
    from hil.setup.conform.suite import chosen
    from hil.wire.side_channel import Control

    rules = chosen(only, SENSOR_RULES)
    sensor = _made(url, file)
    path = sensor.driver.address.emulator
    with ExitStack() as stack:
        control = None
        if path is not None:
            control = Control(path)
            stack.callback(control.close)
        bench = SensorBench(
            kind=type(sensor.driver),
            address=sensor.driver.address,
            file=sensor.file,
            control=control,
            seconds=seconds,
        )
        yield from conform_sensor(bench, rules)


def _show(wrench: Wrench, age: int) -> None:
    values = " ".join(f"{value:9.3f}" for value in (*wrench.force, *wrench.torque))
    click.echo(f"\r{values} N, N.m   age {age} ticks ", err=True, nl=False)
