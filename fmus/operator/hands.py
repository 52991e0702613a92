"""Hands by name: arms that hold a finger directly, and arms behind the give of a grip.

An arm is a spring and a damper; its mass goes into the pantograph's ``finger_mass``. Where a grip
is in between, the arm's mass hangs behind it: grip k₁, b₁ in series with m on k₂, b₂ (the five
parameters of Speich, Shao and Goldfarb, Mechatronics 15, 2005, for below 30 Hz).
"""

from __future__ import annotations

from dataclasses import dataclass

OURS = "assumed: our choice within what is reported for a hand that holds a stylus"
MEASURED = "one trial of one person: Scientific Reports 5, 18004 (2015), figure 3"
SCALED = "assumed: that arm with half and twice its stiffness, at the same damping ratio"
GRIP = "assumed: that arm behind a grip that stiffens with its force, as in Hasser, Cutkosky (2002)"


@dataclass(frozen=True, slots=True)
class NamedHand:
    """How a hand holds on.

    Attributes:
        name: in ``impedance``.
        stiffness: k of the arm, N/m.
        damping: b, N·s/m.
        source: where the numbers come from, or that they are assumed.
        mass: m of the arm, kg; behind the grip where there is one.
        grip_stiffness: k of the grip, N/m; 0: none.
        grip_damping: b of the grip, N·s/m.
    """

    name: str
    stiffness: float
    damping: float
    source: str
    mass: float = 0.0
    grip_stiffness: float = 0.0
    grip_damping: float = 0.0

    @property
    def description(self) -> str:
        """For people, in the model's description."""
        said = f"{self.stiffness:g} N/m, {self.damping:g} N.s/m"
        if self.mass:
            said += f", {self.mass:g} kg"
        if self.grip_stiffness:
            said += f" behind {self.grip_stiffness:g} N/m, {self.grip_damping:g} N.s/m"
        elif self.mass:
            said += " (which goes into finger_mass)"
        return f"{said}; {self.source}"

    @property
    def row(self) -> tuple[float, ...]:
        """For the C side: arm k, b, m, grip k, b; m only where there is a grip."""
        mass = self.mass if self.grip_stiffness else 0.0
        return (self.stiffness, self.damping, mass, self.grip_stiffness, self.grip_damping)


HANDS = (
    NamedHand("relaxed", 100.0, 3.0, OURS),
    NamedHand("normal", 300.0, 8.0, OURS),
    NamedHand("stiff", 800.0, 15.0, OURS),
    NamedHand("arm_soft", 67.5, 4.56, SCALED, mass=0.554),
    NamedHand("arm", 135.0, 6.45, MEASURED, mass=0.554),
    NamedHand("arm_stiff", 270.0, 9.12, SCALED, mass=0.554),
    NamedHand("grip_1_newton", 135.0, 6.45, GRIP, 0.554, 300.0, 3.0),
    NamedHand("grip_2_newton", 135.0, 6.45, GRIP, 0.554, 600.0, 4.5),
    NamedHand("grip_3_newton", 135.0, 6.45, GRIP, 0.554, 900.0, 6.0),
)
"""In the order of their numbers in ``impedance``, from 1 on."""
CUSTOM_GRIP = len(HANDS) + 1
GRIPPED = 1 + next(number for number, hand in enumerate(HANDS) if hand.grip_stiffness)
"""From this number on there is a grip in between."""
