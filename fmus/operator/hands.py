"""Hands by name: arms that hold a finger directly, and arms behind the give of a grip.

An arm is a spring and a damper; its mass goes into the pantograph's ``finger_mass``. Where a grip
is in between, the arm's mass hangs behind it: grip k₁, b₁ in series with m on k₂, b₂ (the five
parameters of Speich, Shao and Goldfarb, Mechatronics 15, 2005, for below 30 Hz). Every number says
where it was published or that it is assumed; docs/people.md has the references.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import groupby

ASSUMED = "assumed"
"""What the source of a number begins with that nobody has published."""
OURS = f"{ASSUMED}: our choice"
MEASURED = "van Beek et al. (2015), one trial of one person"
HALF = f"{ASSUMED}: half of that arm's stiffness, its damping ratio"
TWICE = f"{ASSUMED}: twice that arm's stiffness, its damping ratio"
GRIP_STIFFNESS = f"{ASSUMED}: linear in the grip's force, which Höppner et al. (2013) found"
GRIP_DAMPING = f"{ASSUMED}: more with more grip, which Hasser and Cutkosky (2002) found"


@dataclass(frozen=True, slots=True)
class SourcedValue:
    """A value, and where it was published or that it is assumed."""

    value: float
    source: str

    @property
    def is_assumed(self) -> bool:
        """Whether nobody has published it."""
        return self.source.startswith(ASSUMED)


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedHand:
    """How a hand holds on.

    Attributes:
        name: in ``impedance``.
        stiffness: k of the arm, N/m.
        damping: b, N·s/m.
        mass: m of the arm, kg, where it is known; behind the grip where there is one.
        grip_stiffness: k of the grip, N/m; ``None``: no grip.
        grip_damping: b of the grip, N·s/m.
    """

    name: str
    stiffness: SourcedValue
    damping: SourcedValue
    mass: SourcedValue | None = None
    grip_stiffness: SourcedValue | None = None
    grip_damping: SourcedValue | None = None

    @property
    def numbers(self) -> tuple[SourcedValue, ...]:
        """All that it has."""
        return tuple(number for number, _ in self._said())

    @property
    def description(self) -> str:
        """For people, in the model's description: numbers of one source together."""
        parts: list[str] = []
        for source, same in groupby(self._said(), lambda said: said[0].source):
            parts.append(f"{', '.join(text for _, text in same)} ({source})")
        return ", ".join(parts)

    @property
    def row(self) -> tuple[float, ...]:
        """For the C side: arm k, b, m, grip k, b; m only where there is a grip."""
        mass = self.mass if self.grip_stiffness else None
        given = (self.stiffness, self.damping, mass, self.grip_stiffness, self.grip_damping)
        return tuple(0.0 if number is None else number.value for number in given)

    def _said(self) -> list[tuple[SourcedValue, str]]:
        """Each number with its unit, and what it is of."""
        of_mass = "kg" if self.grip_stiffness else "kg for finger_mass"
        given = (
            (self.stiffness, "N/m"),
            (self.damping, "N.s/m"),
            (self.mass, of_mass),
            (self.grip_stiffness, "N/m"),
            (self.grip_damping, "N.s/m of the grip"),
        )
        return [
            (number, f"{'behind ' * (number is self.grip_stiffness)}{number.value:g} {unit}")
            for number, unit in given
            if number is not None
        ]


def _of(source: str) -> Callable[[float], SourcedValue]:
    return lambda value: SourcedValue(value, source)


_ours, _measured, _half, _twice = (_of(source) for source in (OURS, MEASURED, HALF, TWICE))


def _holding(name: str, stiffness: float, damping: float) -> NamedHand:
    return NamedHand(name=name, stiffness=_ours(stiffness), damping=_ours(damping))


def _gripping(name: str, stiffness: float, damping: float) -> NamedHand:
    """The measured arm behind a grip."""
    return NamedHand(
        name=name,
        stiffness=_measured(135.0),
        damping=_measured(6.45),
        mass=_measured(0.554),
        grip_stiffness=SourcedValue(stiffness, GRIP_STIFFNESS),
        grip_damping=SourcedValue(damping, GRIP_DAMPING),
    )


HANDS = (
    _holding("relaxed", 100.0, 3.0),
    _holding("normal", 300.0, 8.0),
    _holding("stiff", 800.0, 15.0),
    NamedHand(name="arm_soft", stiffness=_half(67.5), damping=_half(4.56), mass=_measured(0.554)),
    NamedHand(
        name="arm", stiffness=_measured(135.0), damping=_measured(6.45), mass=_measured(0.554)
    ),
    NamedHand(
        name="arm_stiff", stiffness=_twice(270.0), damping=_twice(9.12), mass=_measured(0.554)
    ),
    _gripping("grip_1_newton", 300.0, 3.0),
    _gripping("grip_2_newton", 600.0, 4.5),
    _gripping("grip_3_newton", 900.0, 6.0),
)
"""In the order of their numbers in ``impedance``, from 1 on."""
CUSTOM_GRIP = len(HANDS) + 1
GRIPPED = 1 + next(number for number, hand in enumerate(HANDS) if hand.grip_stiffness)
"""From this number on there is a grip in between."""
