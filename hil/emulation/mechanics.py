"""What an emulated device is made of, where it is not as published: what a host has to find out.

A device of one's own is heavier, rubs more, pushes less than it is told and was homed a little off.
An emulator that is so, too, shows whether all of that is found.
"""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from cosim.base.document.form import Form, QuantityIn, read_form
from hil.emulation.plant import Hand
from hil.safety.linkage import Pair

Inertia = Annotated[float, QuantityIn(unit="kg.m2", what="inertia (kg.m2)", least=0, most=1)]
Mass = Annotated[float, QuantityIn(unit="kg", what="mass, such as 0.05 or '50 g'", least=0, most=5)]
Friction = Annotated[float, QuantityIn(unit="N.m", what="torque, such as 0.004", least=0, most=1)]
Gain = Annotated[float, QuantityIn(unit="1", what="factor from 0.1 to 10", least=0.1, most=10)]
Error = Annotated[float, QuantityIn(unit="rad", what="angle, such as 0.01", least=-0.2, most=0.2)]


class HeldForm(Form):
    """``hand`` of an emulated device."""

    stiffness: Annotated[
        float, QuantityIn(unit="N/m", what="stiffness (N/m)", least=0, most=1e5)
    ] = Field(default=100.0, description="How stiffly a hand holds the handle (N/m).")
    damping: Annotated[
        float, QuantityIn(unit="N.s/m", what="damping (N.s/m)", least=0, most=1e3)
    ] = Field(default=3.0, description="How it damps it (N.s/m); both 0: nobody holds it.")


class Mechanics(Form):
    """What an emulated pantograph is made of; what is not given stays as it is."""

    payload: Mass | None = Field(
        default=None,
        description="Mass on the tip (kg); without it that of a hand, 0 where nobody holds it.",
    )
    proximal_inertia: Inertia | None = Field(
        default=None, description="Of each proximal link about its motor (kg.m2)."
    )
    distal_mass: Mass | None = Field(default=None, description="Of each distal link (kg).")
    distal_inertia: Inertia | None = Field(
        default=None, description="Of each distal link about its centre (kg.m2)."
    )
    tip_mass: Mass | None = Field(default=None, description="Of the device's end effector (kg).")
    coulomb_friction: Friction | None = Field(
        default=None, description="Coulomb friction of each joint (N.m)."
    )
    viscous_friction: (
        Annotated[float, QuantityIn(unit="N.m.s/rad", what="viscous friction", least=0, most=1)]
        | None
    ) = Field(default=None, description="Viscous friction of each joint (N.m.s/rad).")
    delay: (
        Annotated[
            float,
            QuantityIn(unit="1", what="number of ticks from 0 to 8", least=0, most=8, whole=True),
        ]
        | None
    ) = Field(default=None, description="Ticks until a command acts, the wire's own not counted.")
    torque_gain: Annotated[list[Gain], Field(min_length=2, max_length=2)] = Field(
        default=[1.0, 1.0], description="What each motor gives of what it is told."
    )
    home_error: Annotated[list[Error], Field(min_length=2, max_length=2)] = Field(
        default=[0.0, 0.0], description="By how much it is homed to show too much (rad)."
    )
    noise: Annotated[
        float, QuantityIn(unit="rad", what="angle, such as 1e-4", least=0, most=0.1)
    ] = Field(default=0.0, description="Standard deviation of an angle before it is counted (rad).")
    hand: HeldForm | None = Field(default=None, description="Who holds the handle.")

    @property
    def parameters(self) -> dict[str, Any]:
        """Those of the pantograph FMU that it gives."""
        names = {"payload": "finger_mass", "delay": "computation_delay_ticks"}
        own = self.model_dump(
            exclude_none=True, exclude={"torque_gain", "home_error", "noise", "hand"}
        )
        return {names.get(name, name): value for name, value in own.items()}

    @property
    def gain(self) -> Pair:
        """Of the two motors."""
        return self.torque_gain[0], self.torque_gain[1]

    def held(self, otherwise: Hand) -> Hand:
        """The hand that holds the handle."""
        return otherwise if self.hand is None else Hand(self.hand.stiffness, self.hand.damping)

    def homed(self, angle: Pair) -> Pair:
        """What a pose is taken for by whoever homed it."""
        return angle[0] + self.home_error[0], angle[1] + self.home_error[1]


def load(path: Path) -> Mechanics:
    """Read a file of them.

    Raises:
        InputError: it cannot be read, or a value in it is none; each with its place.
    """
    from cosim.base.document.yaml_reader import read_yaml

    return read_form(Mechanics, read_yaml(path, str(path)), "an emulator's mechanics")
