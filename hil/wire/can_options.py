"""What the URL of a device on a CAN bus may say of the bus."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cosim.base.document.form import QuantityIn
from cosim.base.errors import InputError
from hil.setup.address import DeviceAddress
from hil.setup.options import UrlOptions, read_options
from hil.wire.can_load import BITRATE

BUDGET_SECONDS = 600e-6
"""What all devices of a station may take of a tick."""


class CanOptions(UrlOptions):
    """Options of a device on a CAN bus."""

    bitrate: Annotated[
        int,
        QuantityIn(
            unit="1", what="bit rate, such as 1000000", least=10_000, most=8_000_000, whole=True
        ),
    ] = Field(default=BITRATE, description="Bits a second on the bus.")
    budget: Annotated[
        float, QuantityIn(unit="s", what="time, such as 0.0006 or '600 us'", above=0, most=600)
    ] = Field(default=BUDGET_SECONDS, description="What all its devices may take of a tick (s).")
    sleep_after_open: Annotated[
        float, QuantityIn(unit="s", what="time, such as 2", least=0, most=60)
    ] = Field(default=2.0, description="slcan: pause after opening (s).")


def refuse_other_options(bitrate: float, budget: float, address: DeviceAddress) -> None:
    """Refuse a device whose URL wants another bus than the one that it would share.

    Raises:
        InputError: its bit rate or budget differs.
    """
    given = can_options(address)
    for name, shared, own in (
        ("bitrate", bitrate, given.bitrate),
        ("budget", budget, given.budget),
    ):
        if own != shared:
            raise InputError(
                f"{address.url} has '{name}' {own:g}, another device on "
                f"{address.transport}://{address.place} has {shared:g}: a bus has one; write the "
                "same in both URLs"
            )


def can_options(address: DeviceAddress) -> CanOptions:
    """The bus's options in a device's URL.

    Raises:
        InputError: one cannot be, or has no effect on this kind of bus.
    """
    if "sleep_after_open" in address.options and address.transport != "slcan":
        raise InputError(
            f"the device URL {address.url}: 'sleep_after_open' is for slcan adapters; leave it out"
        )
    return read_options(CanOptions, address)
