"""What the device file and the URL of a pair of ODrive axes may say."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from cosim.base.document.form import Form, QuantityIn, problem
from hil.setup.driver_facts import DriverSettings
from hil.setup.options import IntegersIn
from hil.wire.can_options import CanOptions

Endpoint = Annotated[
    int, QuantityIn(unit="1", what="endpoint number", least=0, most=65535, whole=True)
]


class OdriveOptions(CanOptions):
    """Options in an ODrive's URL."""

    nodes: Annotated[
        tuple[int, ...],
        IntegersIn(least=0, most=63, what="two different node numbers of 0 to 63, such as 0,1"),
    ] = Field(default=(0, 1), description="Node numbers of the two axes.")


class OdriveWatchdog(Form):
    """The axes' watchdog, off in a new ODrive."""

    timeout: (
        Annotated[
            float,
            QuantityIn(unit="s", what="time, such as 0.02 or '20 ms'", above=0, most=60),
        ]
        | None
    ) = Field(default=None, description="Silence until it fires (s); off unless it is given.")
    timeout_endpoint: Endpoint | None = Field(
        default=None, description="Endpoint of `axis.config.watchdog_timeout`."
    )
    enable_endpoint: Endpoint | None = Field(
        default=None, description="Endpoint of `axis.config.enable_watchdog`."
    )

    @model_validator(mode="after")
    def _has_a_timeout(self) -> OdriveWatchdog:
        for name in ("timeout_endpoint", "enable_endpoint"):
            if self.timeout is None and getattr(self, name) is not None:
                raise problem(f"'{name}' is written with a 'timeout' only; give one (s).")
        return self


class OdriveSettings(DriverSettings):
    """``settings`` in an ODrive's device file."""

    current_limit: Annotated[
        float, QuantityIn(unit="A", what="current, such as 10", above=0, most=1000)
    ] = Field(default=10.0, description="Largest motor current (A).")
    firmware: Literal["0.5", "0.6"] = Field(
        default="0.6", description="The board's firmware, in quotes."
    )
    watchdog: OdriveWatchdog = Field(default=OdriveWatchdog(), description="The axes' watchdog.")

    @model_validator(mode="after")
    def _has_endpoints(self) -> OdriveSettings:
        watchdog = self.watchdog
        given = watchdog.timeout_endpoint is not None or watchdog.enable_endpoint is not None
        if self.firmware == "0.5" and given:
            raise problem(
                "firmware 0.5 has no endpoints on CAN: set its watchdog over USB, and give "
                "'timeout' alone here."
            )
        return self
