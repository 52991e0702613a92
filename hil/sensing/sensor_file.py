"""The file of one particular sensor: its channels, their calibration, and how it is tared."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from cosim.base.document.form import Form, QuantityIn, check_form, plain_node
from cosim.base.document.node import Node
from cosim.base.document.problems import Problems
from cosim.base.errors import InputError, Location
from cosim.base.suggest import did_you_mean
from hil.sensing.sensor_preset import LoadChannel, SensorPreset
from hil.setup.device_form import Date, Serial
from hil.setup.driver_facts import DriverSettings

MOST_CHANNELS = 6
LEAST_RANGE, LARGEST_FORCE, LARGEST_TORQUE = 1e-3, 1e4, 1e3
"""Ranges (N or N.m, N, N.m) of channels that a hand can load; others are a slip of the unit."""

NewtonPerCount = Annotated[
    float,
    QuantityIn(unit="N", what="force per count, such as 0.001 or '1 mN'", least=-1e3, most=1e3),
]
TorquePerCount = Annotated[
    float,
    QuantityIn(
        unit="N.m", what="torque per count, such as 1e-5 or '10 uN.m'", least=-1e3, most=1e3
    ),
]
RawCounts = Annotated[
    int,
    QuantityIn(unit="1", what="whole number of counts", least=-(2**31), most=2**31 - 1, whole=True),
]
FullScale = Annotated[
    int,
    QuantityIn(unit="1", what="whole number of counts", least=16, most=2**31 - 1, whole=True),
]


class LoadChannelForm(Form):
    """One converter of the board."""

    force: Annotated[list[NewtonPerCount], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0], description="Force along x, y, z of one count (N)."
    )
    torque: Annotated[list[TorquePerCount], Field(min_length=3, max_length=3)] = Field(
        default=[0.0, 0.0, 0.0], description="Torque about x, y, z of one count (N.m)."
    )
    zero: RawCounts = Field(default=0, description="Counts without load.")
    full_scale: FullScale = Field(
        description="Counts, of either sign, at which the range ends: no value from there on."
    )


class SensorSettings(DriverSettings):
    """`settings` in a sensor's file."""

    channels: (
        Annotated[list[LoadChannelForm], Field(min_length=1, max_length=MOST_CHANNELS)] | None
    ) = Field(default=None, description="The board's converters in its order; else the preset's.")
    tare: bool = Field(
        default=True,
        description="Whether opening takes the load as zero; the sensor has to be free, at rest.",
    )


class SensorFileForm(Form):
    """One particular force sensor on one particular bench."""

    cohaptic_device: Literal[1] = Field(default=1, description="The version of device files.")
    driver: str = Field(description="The driver's name: `driver: force_sensor`.")
    preset: str | None = Field(default=None, description="Whose channels hold unless given.")
    serial: Serial | None = Field(default=None, description="Another sensor is refused.")
    date: Date | None = Field(default=None, description="When it was calibrated.")
    settings: SensorSettings = Field(
        default=SensorSettings(), description="Channels, and how it is tared."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorFile:
    """Everything that is known of a sensor before it is opened."""

    driver: str
    preset: str
    channels: tuple[LoadChannel, ...]
    tare: bool = True
    serial: str | None = None
    date: str | None = None
    path: Path | None = None


def load(path: Path, presets: Mapping[str, SensorPreset], standard: str) -> SensorFile:
    """Read a sensor's file; ``presets`` are its driver's, ``standard`` the one that it means.

    Raises:
        InputError: it cannot be read, or values in it cannot be; each with its place.
    """
    from cosim.base.document.yaml_reader import read_yaml

    try:
        root = read_yaml(path, str(path))
    except InputError as error:
        if error.location is not None:
            raise
        raise InputError(f"the device file {path} cannot be used: {error.message}") from error
    return _read(root, presets, standard, path)


def parse(document: Any, presets: Mapping[str, SensorPreset], standard: str) -> SensorFile:
    """The sensor's file in plain data, as :func:`load` finds it in a file.

    Raises:
        InputError: as :func:`load`.
    """
    node = plain_node(document, Location("the device file", 0, 0))
    return _read(node, presets, standard, None)


def _read(
    root: Node, presets: Mapping[str, SensorPreset], standard: str, path: Path | None
) -> SensorFile:
    problems = Problems(root, subject="a sensor's file").of(SensorFileForm)
    form = check_form(SensorFileForm, root, problems)
    problems.raise_if_any()
    assert form is not None, "what is no form has a problem"
    name = form.preset or standard
    if name not in presets:
        problems.add(
            ("preset",), f"there is no preset '{name}' of a sensor.{did_you_mean(name, presets)}"
        )
    given = form.settings.channels
    channels = (
        tuple(_channel(each) for each in given)
        if given is not None
        else presets[name].channels
        if name in presets
        else ()
    )
    for index, channel in enumerate(channels):
        sentence = _implausible(channel)
        if sentence is not None:
            problems.add(
                ("settings", "channels", index), f"settings.channels[{index + 1}]: {sentence}"
            )
    problems.raise_if_any()
    return SensorFile(
        driver=form.driver,
        preset=name,
        channels=channels,
        tare=form.settings.tare,
        serial=form.serial,
        date=form.date,
        path=path,
    )


def _channel(form: LoadChannelForm) -> LoadChannel:
    (fx, fy, fz), (tx, ty, tz) = form.force, form.torque
    return LoadChannel(
        force=(fx, fy, fz), torque=(tx, ty, tz), zero=form.zero, full_scale=form.full_scale
    )


def _implausible(channel: LoadChannel) -> str | None:
    """Why a channel cannot be one, or ``None``."""
    force = max(map(abs, channel.force)) * channel.full_scale
    torque = max(map(abs, channel.torque)) * channel.full_scale
    if max(force, torque) < LEAST_RANGE:
        return (
            f"its range is {force:.2g} N and {torque:.2g} N.m: it would measure nothing; give "
            "'force' or 'torque' what one count is worth."
        )
    if force > LARGEST_FORCE or torque > LARGEST_TORQUE:
        return (
            f"its range is {force:.4g} N and {torque:.4g} N.m, beyond {LARGEST_FORCE:g} N or "
            f"{LARGEST_TORQUE:g} N.m: is the unit of 'force' and 'torque' right?"
        )
    if abs(channel.zero) >= channel.full_scale:
        return "its 'zero' is at the end of its range, or beyond it."
    return None
