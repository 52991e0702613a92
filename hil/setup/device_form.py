"""A device file as it is written: every key, its unit and its meaning."""

from __future__ import annotations

from datetime import date
from math import pi
from typing import Annotated, Any, Literal

from pydantic import Field, PlainValidator, WithJsonSchema, model_validator

from cosim.base.document.form import Form, QuantityIn, problem
from cosim.base.document.show import describe
from hil.safety.form import LARGEST, LimitsForm

LARGEST_OFFSET = 4 * pi
SHORTEST_LINK, LONGEST_LINK = 0.005, 1.0
"""Links (m) between which a hand can be on a tip; longer ones are millimetres taken for metres."""
LEAST_GEAR, LARGEST_GEAR = 1.0, 100.0
"""A gear below one would ask more of the motor than of the joint; above, no hand moves it."""
LEAST_CONSTANT, LARGEST_CONSTANT = 0.001, 10.0
"""Torque constants (N.m/A) from the smallest motors to direct drives."""
LEAST_AMPLIFIER, LARGEST_AMPLIFIER = 0.01, 100.0
"""Of amplifiers (A/V)."""
LARGEST_VOLTAGE = 24.0
"""Of analogue inputs and outputs (V)."""
LARGEST_CODE = 2**31
LARGEST_TORQUE, LARGEST_CURRENT = 10.0, 100.0
"""Ratings (N.m, A) of motors that belong on a desk."""

Metres = Annotated[
    float,
    QuantityIn(unit="m", what="length, such as 0.1 or '100 mm'", least=-1, most=1),
]
LinkLength = Annotated[
    float,
    QuantityIn(
        unit="m", what="length, such as 0.1 or '100 mm'", least=SHORTEST_LINK, most=LONGEST_LINK
    ),
]
Radians = Annotated[
    float,
    QuantityIn(
        unit="rad",
        what="angle, such as 0.7 (rad) or '40 deg'",
        least=-LARGEST_OFFSET,
        most=LARGEST_OFFSET,
    ),
]
Volts = Annotated[
    float,
    QuantityIn(unit="V", what="voltage, such as 2.5", least=-LARGEST_VOLTAGE, most=LARGEST_VOLTAGE),
]
Counts = Annotated[
    int, QuantityIn(unit="1", what="whole number of counts", least=16, most=2**24, whole=True)
]
Code = Annotated[
    int,
    QuantityIn(unit="1", what="whole DAC code", least=-LARGEST_CODE, most=LARGEST_CODE, whole=True),
]
Rated = Annotated[
    float,
    QuantityIn(unit="N.m", what="torque, such as 0.1 or '100 mN.m'", above=0, most=LARGEST_TORQUE),
]
Seconds = Annotated[
    float, QuantityIn(unit="s", what="time, such as 0.02 or '20 ms'", above=0, most=LARGEST)
]


def _to_direction(value: Any) -> int:
    if isinstance(value, bool) or value not in (1, -1):
        raise problem(f"a direction has to be 1 or -1, it is {describe(value)}.")
    return 1 if value == 1 else -1


def _to_date(value: Any) -> str:
    try:
        return date.fromisoformat(value).isoformat()
    except (TypeError, ValueError):
        raise problem(f"{describe(value)} is no date; write it as 2026-03-01.") from None


def _to_serial(value: Any) -> str:
    if isinstance(value, str | int | float) and not isinstance(value, bool) and str(value).strip():
        return str(value)
    raise problem(f"{describe(value)} is no serial number; write it in quotes.")


def _to_reason(value: Any) -> str:
    if isinstance(value, str) and value.strip():
        return value
    raise problem(f"{describe(value)} is no reason; write in words why the limit may be looser.")


Direction = Annotated[int, PlainValidator(_to_direction), WithJsonSchema({"enum": [1, -1]})]
Date = Annotated[
    str, PlainValidator(_to_date), WithJsonSchema({"type": "string", "format": "date"})
]
Serial = Annotated[str, PlainValidator(_to_serial), WithJsonSchema({"type": ["string", "number"]})]
Reason = Annotated[
    str, PlainValidator(_to_reason), WithJsonSchema({"type": "string", "minLength": 1})
]


class GeometryForm(Form):
    """Lengths of the five-bar linkage."""

    proximal: LinkLength | None = Field(default=None, description="Proximal links (m).")
    distal: LinkLength | None = Field(default=None, description="Distal links (m).")
    base: (
        Annotated[
            float,
            QuantityIn(unit="m", what="length, such as 0.04 or '40 mm'", least=0, most=1),
        ]
        | None
    ) = Field(default=None, description="Distance between the two motors (m).")


class DriveForm(Form):
    """From joint torque to what the device takes; `torque_constant` and `amplifier`: volts."""

    direction: Direction = Field(default=1, description="The sign of the motor's torque.")
    gear: Annotated[
        float,
        QuantityIn(unit="1", what="ratio, such as 1 or 7.5", least=LEAST_GEAR, most=LARGEST_GEAR),
    ] = Field(default=1.0, description="Joint torque per motor torque.")
    torque_constant: (
        Annotated[
            float,
            QuantityIn(
                unit="N.m/A",
                what="torque constant, such as 0.0364 or '36.4 mN.m/A'",
                least=LEAST_CONSTANT,
                most=LARGEST_CONSTANT,
            ),
        ]
        | None
    ) = Field(default=None, description="Of the motor (N.m/A).")
    amplifier: (
        Annotated[
            float,
            QuantityIn(
                unit="A/V",
                what="gain of an amplifier, such as 0.5",
                least=LEAST_AMPLIFIER,
                most=LARGEST_AMPLIFIER,
            ),
        ]
        | None
    ) = Field(default=None, description="Amperes that the amplifier gives for a volt (A/V).")
    bias: Volts = Field(default=0.0, description="The voltage without torque (V).")
    low: Volts = Field(default=-10.0, description="The DAC's lowest voltage (V).")
    high: Volts = Field(default=10.0, description="The DAC's highest voltage (V).")
    low_code: Code = Field(default=-32767, description="The code of the lowest voltage.")
    high_code: Code = Field(default=32767, description="The code of the highest voltage.")


class MotorForm(Form):
    """What the motors are rated for, at their own shafts; by default the preset's."""

    peak_torque: Rated | None = Field(
        default=None, description="Torque that they give for seconds at most (N.m)."
    )
    continuous_torque: Rated | None = Field(
        default=None, description="Torque that they may hold for ever (N.m)."
    )
    peak_current: (
        Annotated[
            float, QuantityIn(unit="A", what="current, such as 5", above=0, most=LARGEST_CURRENT)
        ]
        | None
    ) = Field(default=None, description="Current that they or their amplifiers take (A).")


class JointForm(Form):
    """One proximal link: joint angle = direction * shaft angle + offset."""

    direction: Direction = Field(default=1, description="Which way it counts.")
    offset: Radians = Field(default=0.0, description="Joint angle at shaft angle zero (rad).")
    counts_per_turn: Counts | None = Field(
        default=None, description="Counts of the encoder per turn of the shaft."
    )
    drive: DriveForm = Field(default=DriveForm(), description="What drives it.")


class WorkspaceForm(Form):
    """Where the tip may be, in the device's own frame."""

    left: Metres = Field(description="Least x (m).")
    right: Metres = Field(description="Largest x (m).")
    bottom: Metres = Field(description="Least y (m).")
    top: Metres = Field(description="Largest y (m).")

    @model_validator(mode="after")
    def _not_empty(self) -> WorkspaceForm:
        if self.left >= self.right or self.bottom >= self.top:
            raise problem("it is empty: left < right and bottom < top are needed.")
        return self


class LoosenedForm(Form):
    """Why a limit, or the workspace, is looser than the default, by its name."""

    torque: Reason | None = None
    continuous_torque: Reason | None = None
    peak_time: Reason | None = None
    slew: Reason | None = None
    tip_speed: Reason | None = None
    joint_speed: Reason | None = None
    dexterity: Reason | None = None
    ramp_time: Reason | None = None
    workspace: Reason | None = None


class WatchdogProofForm(Form):
    """Written by `cohaptic device check --enable-output`: the watchdog was seen to fire."""

    date: Date = Field(description="When it was seen.")
    timeout: Seconds = Field(description="The watchdog's timeout then (s).")
    fired_after: Seconds = Field(description="How long the device was silent until it fired (s).")
    serial: Serial | None = Field(default=None, description="On which device.")


class DeviceFileForm(Form):
    """One particular device on one particular bench."""

    cohaptic_device: Literal[1] = Field(default=1, description="The version of device files.")
    driver: str = Field(description="The driver's name: `driver: haply`.")
    preset: str | None = Field(
        default=None,
        description="Whose geometry, counts, motor and drive hold unless they are given: "
        "`quanser`, `haply`, or another that an installed driver brings.",
    )
    serial: Serial | None = Field(default=None, description="Another device is refused.")
    date: Date | None = Field(default=None, description="When it was calibrated.")
    estop: Literal["confirmed", "none"] | None = Field(
        default=None, description="`confirmed`: a person stands by a switch that cuts the power."
    )
    geometry: GeometryForm = Field(default=GeometryForm(), description="The linkage.")
    motor: MotorForm = Field(default=MotorForm(), description="What the motors are rated for.")
    joints: Annotated[list[JointForm], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="The two joints."
    )
    home: Annotated[list[Radians], Field(min_length=2, max_length=2)] | None = Field(
        default=None, description="Joint angles of the pose in which it is homed (rad)."
    )
    limits: LimitsForm = Field(default=LimitsForm(), description="Limits by name.")
    loosened: LoosenedForm = Field(
        default=LoosenedForm(),
        description="Why a limit, or the workspace, is looser than the default, by name.",
    )
    workspace: WorkspaceForm | None = Field(default=None, description="Where the tip may be.")
    settings: Any = Field(default=None, description="What belongs to one driver alone.")
    watchdog_proof: WatchdogProofForm | None = Field(
        default=None, description="Written by `cohaptic device check --enable-output`."
    )
