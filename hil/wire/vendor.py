"""Makers' own Python packages: imported when a device is opened, never before.

None of them is a dependency of cohaptic, and none of their handles can go to another process. So
the control loop opens such a device itself, the supervisor cannot zero it, and output needs a
watchdog on the board that was seen to fire on this very device (``hil.safety.safeguards``).
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from math import ceil
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from cosim.base.document.form import Form, QuantityIn, mapping_tag
from cosim.base.errors import InputError
from hil.safety.conversion import VoltageDrive
from hil.safety.linkage import Pair
from hil.setup.device_file import Joint
from hil.setup.driver_facts import DriverSettings

WATCHDOG_SECONDS = 0.020
PROOF = 5.0
"""A watchdog that is let expire has to do so within so many of its timeouts."""


Timeout = Annotated[
    float,
    QuantityIn(
        unit="s",
        what="watchdog timeout, such as 0.02 or '20 ms'; a hand feels what comes later than 0.1 s",
        least=0.002,
        most=0.1,
    ),
]


class WatchdogForm(Form):
    """The board's watchdog."""

    timeout: Timeout = Field(default=WATCHDOG_SECONDS, description="Silence until it fires (s).")


class VendorSettings(DriverSettings):
    """``settings`` of a device that is reached through its maker's package."""

    watchdog: Annotated[
        Annotated[Timeout, Tag("plain")] | Annotated[WatchdogForm, Tag("mapping")],
        Discriminator(mapping_tag),
    ] = Field(default=WatchdogForm(), description="The board's watchdog.")

    @property
    def timeout(self) -> float:
        """The watchdog's timeout (s)."""
        given = self.watchdog
        return given.timeout if isinstance(given, WatchdogForm) else given


def vendor(module: str, *, driver: str, install: str) -> Any:
    """A maker's module.

    Raises:
        InputError: it is not installed; the sentence says how to install it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise InputError(
            f"the driver '{driver}' needs its maker's package '{module}', which cannot be "
            f"imported ({error}): {install}"
        ) from error


def fires(expired: Callable[[], bool], pause: Callable[[], None], ticks: float) -> bool:
    """Whether a watchdog that nobody feeds expires within :data:`PROOF` timeouts (``ticks``)."""
    for _ in range(ceil(PROOF * ticks)):
        if expired():
            return True
        pause()
    return expired()


def volts(joints: tuple[Joint, Joint], torque: Pair) -> tuple[Pair, Pair]:
    """What a card with analogue outputs is given (V), and the joint torques that gives (N.m).

    Raises:
        InputError: a joint's drive takes torque and not volts.
    """
    voltage: list[float] = []
    given: list[float] = []
    for joint, wanted in zip(joints, torque, strict=True):
        drive = joint.drive
        if not isinstance(drive, VoltageDrive):
            raise InputError("this card takes volts: 'drive' needs torque_constant and amplifier")
        code = drive.encode(wanted)
        voltage.append(drive.voltage(code))
        given.append(drive.decode(code))
    return (voltage[0], voltage[1]), (given[0], given[1])
