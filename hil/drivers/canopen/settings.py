"""What the device file and the URL of a CANopen device may say: layout, times, pose."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, isfinite
from typing import Annotated, Literal

from pydantic import Field, model_validator

from cosim.base.document.form import QuantityIn, problem
from cosim.base.errors import InputError
from hil.drivers.canopen.layout import CanopenLayout, layout
from hil.drivers.canopen.object_form import ObjectForm
from hil.drivers.canopen.protocol import LAST_NODE
from hil.safety.conversion import VoltageDrive
from hil.setup.address import DeviceAddress
from hil.setup.device_file import DeviceFile
from hil.setup.driver_facts import DriverSettings
from hil.setup.options import IntegersIn, read_options
from hil.wire.can_options import CanOptions

HEARTBEAT_MS, WATCHDOG_MS = 5, 20
"""How often a node and we say that we are alive; how long a node lets us be silent."""
LEAST_WATCHDOG_TICKS = 4
TIMEOUT_SECONDS = 5.0
RESIDUAL_SHARE = 0.01
"""Largest torque at code 0, which outputs drop to by themselves, as a share of the limit."""

Nodes = Annotated[
    tuple[int, ...],
    IntegersIn(
        counts=(1, 2, 3),
        least=1,
        most=LAST_NODE,
        what="one node with both joints, two with one each, or two encoders and a node with both "
        f"outputs: different numbers of 1 to {LAST_NODE}",
    ),
]
Milliseconds = Annotated[
    int,
    QuantityIn(
        unit="ms", what="time in whole ms, such as 5 or '5 ms'", least=1, most=1000, whole=True
    ),
]
SetupSeconds = Annotated[
    float, QuantityIn(unit="s", what="time, such as 5 or '500 ms'", above=0, most=600)
]


class NodeOptions(CanOptions):
    """Options in the URL of every device on a CANopen bus."""

    pipelined: Literal["0", "1"] = Field(
        default="0",
        description="1: answers to a SYNC are read at the next tick: no waiting, one tick later.",
    )


def is_pipelined(address: DeviceAddress) -> bool:
    """Whether answers to a SYNC are read at the next tick.

    Raises:
        InputError: the option cannot be.
    """
    return read_options(NodeOptions, address).pipelined == "1"


class CanopenOptions(NodeOptions):
    """Options in a CANopen device's URL."""

    nodes: Nodes | None = Field(default=None, description="Node numbers; they win over the file's.")


def _different(joints: list[ObjectForm] | None, name: str) -> None:
    if joints is not None and joints[0] == joints[1]:
        raise problem(f"'{name}' gives both joints the same object of the same node.")


TwoObjects = Annotated[list[ObjectForm], Field(min_length=2, max_length=2)]


class CanopenSettings(DriverSettings):
    """``settings`` in a CANopen device's file."""

    nodes: Nodes = Field(default=(1,), description="Node numbers, which choose a usual layout.")
    encoders: TwoObjects | None = Field(default=None, description="Each joint's encoder.")
    outputs: TwoObjects | None = Field(default=None, description="Each joint's output.")
    absolute: bool = Field(
        default=False, description="Encoders that know their pose: no home pose is needed."
    )
    preset: bool = Field(
        default=True, description="Whether homing writes the encoders' preset values."
    )
    heartbeat: Milliseconds = Field(
        default=HEARTBEAT_MS, description="How often nodes and we say that we are alive (ms)."
    )
    watchdog: Milliseconds = Field(
        default=WATCHDOG_MS, description="How long a node lets us be silent (ms)."
    )
    timeout: SetupSeconds = Field(
        default=TIMEOUT_SECONDS, description="For an answer during set-up (s)."
    )

    @model_validator(mode="after")
    def _both_differ(self) -> CanopenSettings:
        _different(self.encoders, "encoders")
        _different(self.outputs, "outputs")
        if any(each.channel == 0 for each in self.outputs or ()):
            raise problem("an output's 'channel' is from 1 to 254.")
        return self


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """A device's settings."""

    layout: CanopenLayout
    drives: tuple[VoltageDrive, VoltageDrive]
    heartbeat_ms: int
    watchdog_ms: int
    timeout: float
    """For an answer during set-up (s)."""
    preset: bool
    """Whether homing writes the encoders' preset values."""

    @property
    def zero_codes(self) -> tuple[int, int]:
        """Output values without torque."""
        return self.drives[0].zero_code, self.drives[1].zero_code


def settings(address: DeviceAddress, file: DeviceFile, tick: float) -> Settings:
    """The settings of a device with control period ``tick`` (s).

    Raises:
        InputError: one of them cannot be.
    """
    given = file.settings_of(CanopenSettings)
    return Settings(
        layout=layout_of(address, file),
        drives=(_drive(file, 0), _drive(file, 1)),
        heartbeat_ms=max(given.heartbeat, ceil(tick * 1e3)),
        watchdog_ms=max(given.watchdog, ceil(LEAST_WATCHDOG_TICKS * tick * 1e3)),
        timeout=given.timeout,
        preset=given.preset,
    )


def layout_of(address: DeviceAddress, file: DeviceFile) -> CanopenLayout:
    """The layout of a device, from its URL and its file.

    Raises:
        InputError: an option in the URL cannot be.
    """
    given = file.settings_of(CanopenSettings)
    nodes = read_options(CanopenOptions, address).nodes or given.nodes
    return layout(nodes, given.encoders, given.outputs)


def _drive(file: DeviceFile, joint: int) -> VoltageDrive:
    drive = file.joints[joint].drive
    if not isinstance(drive, VoltageDrive):
        raise InputError("a CANopen analogue output takes volts: give 'torque_constant'")
    residual = drive.decode(0)
    if not isfinite(residual) or abs(residual) > RESIDUAL_SHARE * file.limits.torque:
        raise InputError(
            f"an output that drops to code 0 on an error would leave {residual:.4g} N.m with this "
            "'bias': trim the amplifier, so that 0 V is no torque"
        )
    return drive
