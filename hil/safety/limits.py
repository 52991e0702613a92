"""The safety limits of a device, their defaults, and the rule for loosening one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from math import floor

TIGHTER_IS_LARGER = frozenset({"ramp_time", "dexterity"})
"""Limits that protect more when they are larger; every other one protects more when smaller."""

HOLD_SECONDS = 0.002
"""Up to this age of the data the torque is held as commanded."""
DROP_SECONDS = 0.010
"""From this age on the torque is zero and the device is in FAULT."""
LATE_SECONDS = 0.010
"""A write that comes later than this after the previous one is zero, and the device faults."""
ACTIVATION_TIP_SPEED = 0.02
"""Activation is refused while the tip moves faster (m/s)."""
FIRST_COMMAND_SHARE = 0.1
"""The first command after activation has to be below this share of the torque limit."""
SPEED_WINDOW_SECONDS = 0.03125
"""Tip speed is the chord over this time: one encoder count is then about 7 mm/s."""
VIBRATION_WINDOW_SECONDS = 0.0078125
"""So is the chord over this one, which sees a vibration up to some 50 Hz as well."""
HARD_FACTOR = 4.0
"""How many times its default a limit may be, whatever the reason: beyond it no hand belongs."""
LEAST_RAMP, LONGEST_RAMP = 1.0, 2.0
"""How short, and how long, the ramp after activation may be (s)."""
LEAST_TICKS = 3
"""Ticks that 10 ms have to have: at a slower rate nothing could be dropped in time."""
BORDER_METRES = 0.005
"""Force fades over this last stretch before the workspace's border (m)."""
BORDER_DEXTERITY = 0.2
"""So it does where the dexterity is above its limit by less than this share of the limit."""
REENTRY_SHARE = 0.4
"""A tip that was outside counts as inside again from this share of that stretch on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TickLimits:
    """What is written in ms above as whole ticks of one control rate, rounded down."""

    hold: int
    drop: int
    speed_window: int
    vibration: int

    @classmethod
    def at(cls, tick: float) -> TickLimits:
        """Those of a control period (s); so slow a one that 10 ms have no 3 ticks gets no force."""
        return cls(
            hold=_whole(HOLD_SECONDS, tick),
            drop=max(LEAST_TICKS, _whole(DROP_SECONDS, tick)),
            speed_window=max(2, _whole(SPEED_WINDOW_SECONDS, tick)),
            vibration=max(1, _whole(VIBRATION_WINDOW_SECONDS, tick)),
        )


def too_slow_to_drop(tick: float) -> str | None:
    """Why a control period (s) is too long for any output, as a part of a sentence."""
    if tick * LEAST_TICKS <= LATE_SECONDS:
        return None
    return (
        f"stays without output at {1 / tick:.4g} Hz: what fails there could not be dropped within "
        f"{LATE_SECONDS * 1e3:.0f} ms; control it at {LEAST_TICKS / LATE_SECONDS:.0f} Hz or faster"
    )


def _whole(seconds: float, tick: float) -> int:
    return floor(seconds / tick * (1 + 1e-9))


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """What a device may do to a hand; the defaults suit a small desktop pantograph.

    The defaults come from the devices' published ratings, reduced; a device file tightens them
    freely and loosens one only with a reason, which is printed at every activation.
    """

    torque: float = 0.15
    """Largest torque of a joint (N.m)."""
    continuous_torque: float = 0.08
    """Torque that a motor may hold for ever (N.m)."""
    peak_time: float = 2.0
    """How long a motor may hold ``torque`` before it is brought down to the above (s)."""
    slew: float = 60.0
    """How fast the magnitude of a joint's torque may grow (N.m/s); a reduction is never slowed."""
    tip_speed: float = 1.0
    """Torque fades from 80 % of this speed on; at the speed itself the device faults (m/s)."""
    joint_speed: float = 25.0
    """Counts that move faster than this are no motion but a fault of the encoder (rad/s)."""
    dexterity: float = 0.15
    """Least sine of the angles between the links: nearer to a singular position is outside."""
    ramp_time: float = 1.5
    """How long force takes to come up after activation, 1 to 2 s."""

    def replaced(self, values: Mapping[str, float]) -> Limits:
        """These limits with others in their place."""
        return replace(self, **values)

    def tightened(self, values: Mapping[str, float]) -> Limits:
        """The tighter of these and the given ones, limit by limit."""
        return replace(
            self, **{name: v for name, v in values.items() if not self.is_looser(name, v)}
        )

    def needs_a_reason(self, name: str, value: float) -> str:
        """Why a looser limit is refused as it stands."""
        return (
            f"the limit '{name}: {value:g}' is looser than the default {getattr(self, name)}: "
            f"write why under 'loosened: {{{name}: ...}}', or keep the default."
        )

    def is_looser(self, name: str, value: float) -> bool:
        """Whether a value protects less than this one's."""
        current: float = getattr(self, name)
        return value < current if name in TIGHTER_IS_LARGER else value > current

    def beyond_ceilings(self) -> dict[str, str]:
        """Why limits are refused for good, by name: looser than the hardest that there is."""
        bounds = hard_ceilings()
        return {
            name: f"the limit '{name}: {getattr(self, name):g}' is looser than {bound:g}, the "
            "hard ceiling, which no reason loosens."
            for name, bound in asdict(bounds).items()
            if bounds.is_looser(name, getattr(self, name))
        }


def hard_ceilings() -> Limits:
    """The loosest limits that any device may have: a quarter, or four times, the defaults."""
    standard = asdict(Limits())
    loosest = {
        name: value / HARD_FACTOR if name in TIGHTER_IS_LARGER else value * HARD_FACTOR
        for name, value in standard.items()
    }
    return Limits(**{**loosest, "ramp_time": LEAST_RAMP})
