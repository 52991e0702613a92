"""What the device file and the URL of a pair of CiA 402 drives may say."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from hil.drivers.canopen.protocol import LAST_NODE
from hil.drivers.canopen.settings import (
    HEARTBEAT_MS,
    TIMEOUT_SECONDS,
    WATCHDOG_MS,
    Milliseconds,
    NodeOptions,
    SetupSeconds,
)
from hil.setup.driver_facts import DriverSettings
from hil.setup.options import IntegersIn

Drives = Annotated[
    tuple[int, ...],
    IntegersIn(least=1, most=LAST_NODE, what=f"two node numbers of 1 to {LAST_NODE}, a joint each"),
]


class Cia402Options(NodeOptions):
    """Options in the URL of CiA 402 drives."""

    nodes: Drives | None = Field(
        default=None, description="Node numbers; they win over the file's."
    )


class Cia402Settings(DriverSettings):
    """`settings` in the file of CiA 402 drives."""

    nodes: Drives = Field(default=(1, 2), description="Node numbers of the joints' drives.")
    mode: Literal[4, 10] | None = Field(
        default=None,
        description="Profile torque (4) or cyclic synchronous torque (10); else 10 where offered.",
    )
    rpdo_timer: bool = Field(
        default=True,
        description="Whether drives time our commands (1400h:5); else our heartbeat alone.",
    )
    heartbeat: Milliseconds = Field(
        default=HEARTBEAT_MS, description="How often drives and we say that we are alive (ms)."
    )
    watchdog: Milliseconds = Field(
        default=WATCHDOG_MS, description="How long a drive lets us be silent (ms)."
    )
    timeout: SetupSeconds = Field(
        default=TIMEOUT_SECONDS, description="For an answer during set-up (s)."
    )
