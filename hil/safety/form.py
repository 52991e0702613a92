"""The limits of a device as written: in its device file, in a scenario's ``safety:``."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cosim.base.document.form import Form, QuantityIn
from hil.safety.limits import LEAST_RAMP, LONGEST_RAMP

LARGEST = 1e9
"""No value of a device is as large, in any unit."""

Torque = Annotated[
    float, QuantityIn(unit="N.m", what="torque, such as 0.1 or '100 mN.m'", above=0, most=LARGEST)
]
Seconds = Annotated[
    float, QuantityIn(unit="s", what="time, such as 2 or '500 ms'", above=0, most=LARGEST)
]


class LimitsForm(Form):
    """Limits by name; one that is not given stays what it is."""

    torque: Torque | None = Field(default=None, description="Largest torque of a joint (N.m).")
    continuous_torque: Torque | None = Field(
        default=None, description="Torque that a motor may hold for ever (N.m)."
    )
    peak_time: Seconds | None = Field(
        default=None, description="How long a motor may hold `torque` (s)."
    )
    slew: (
        Annotated[
            float,
            QuantityIn(unit="N.m/s", what="rate, such as 60 or '60 N.m/s'", above=0, most=LARGEST),
        ]
        | None
    ) = Field(default=None, description="How fast a joint's torque may grow (N.m/s).")
    tip_speed: (
        Annotated[
            float,
            QuantityIn(unit="m/s", what="speed, such as 1 or '800 mm/s'", above=0, most=LARGEST),
        ]
        | None
    ) = Field(default=None, description="Tip speed at which the device faults (m/s).")
    joint_speed: (
        Annotated[
            float,
            QuantityIn(unit="rad/s", what="speed, such as 25 or '240 rpm'", above=0, most=LARGEST),
        ]
        | None
    ) = Field(default=None, description="Faster counts are a fault of the encoder (rad/s).")
    dexterity: (
        Annotated[float, QuantityIn(unit="1", what="sine, such as 0.15", above=0, most=1)] | None
    ) = Field(default=None, description="Least sine of the angles between the links.")
    ramp_time: (
        Annotated[
            float,
            QuantityIn(
                unit="s",
                what="time, such as 1.5 or '1500 ms'",
                least=LEAST_RAMP,
                most=LONGEST_RAMP,
            ),
        ]
        | None
    ) = Field(default=None, description="How long force takes to come up, 1 to 2 s.")

    def given(self) -> dict[str, float]:
        """The limits that were written, in SI units."""
        return self.model_dump(exclude_none=True)


class SafetyForm(LimitsForm):
    """Limits of every device of a scenario: the tighter of each and the device's own holds."""
