"""The safety layer: what becomes of a commanded torque before any driver sees it.

One object a device; ``observe`` takes each tick's measurement, ``limit`` each tick's command. It
knows ticks, not clocks, so the same layer runs on hardware, against an emulator in lock-step, and
as a component in simulation. The table in ``docs/safety.md`` states every rule with its ticks.
"""

from __future__ import annotations

from collections import deque
from copy import copy
from dataclasses import dataclass
from math import copysign, hypot, isfinite

from hil.device.contract import ZERO, Flag
from hil.device.errors import Cause
from hil.safety.limits import (
    ACTIVATION_TIP_SPEED,
    BORDER_DEXTERITY,
    BORDER_METRES,
    FIRST_COMMAND_SHARE,
    REENTRY_SHARE,
    Limits,
    TickLimits,
)
from hil.safety.linkage import Linkage, Pair, Region

FADE_SHARE = 0.8
"""Tip speed and heat limits start to bring the torque down at this share of their limit."""
QUANTA = 2
"""Counts by which two honest samples may differ beyond the largest motion (quantisation)."""


@dataclass(frozen=True, slots=True)
class Trip:
    """Why the layer wants the device in FAULT, as a cause and a sentence."""

    cause: Cause
    sentence: str


@dataclass(frozen=True, slots=True)
class Decision:
    """What may be sent (N.m), what was done to the command, and whether the device faults."""

    torque: Pair
    flags: Flag
    trip: Trip | None = None


class SafetyLayer:
    """Limits of one device, with the state they need.

    ``tick`` is the control period (s), ``quantum`` the angle of one encoder count (rad).
    """

    def __init__(
        self,
        limits: Limits,
        linkage: Linkage,
        *,
        tick: float,
        quantum: float,
        region: Region | None = None,
    ) -> None:
        self.limits = limits
        self.linkage = linkage
        self.region = region or linkage.default_region()
        self.tick = tick
        self.quantum = quantum
        self.ticks = TickLimits.at(tick)
        self._trace: deque[tuple[int, Pair]] = deque(maxlen=self.ticks.speed_window + 1)
        self._angle: tuple[int, Pair] | None = None
        self._previous: Pair = ZERO
        self._heat = [0.0, 0.0]
        self._active_ticks = 0
        self._ramp = self._ramp_before_gap = 0.0
        """Share of its force that has come up: from zero, or from where a gap had brought it."""
        self.age = 0
        self.tip_speed = 0.0
        """The chord over the long window (m/s): whether the handle rests."""
        self.fastest = 0.0
        """The larger of the chords over the long and the short window (m/s)."""
        self.tip: Pair | None = None
        self.border = 0.0
        """How far inside the tip is: 0 on the border, 1 where the force begins to fade."""
        self.inside = False

    def copy(self) -> SafetyLayer:
        """An independent layer in the same state (for trying a tick without committing it)."""
        twin = copy(self)
        twin._trace, twin._heat = self._trace.copy(), list(self._heat)
        return twin

    def forget(self) -> None:
        """Drop the motion seen so far: the angles have a new zero."""
        self._trace.clear()
        self._angle = None
        self.tip_speed, self.fastest, self.tip = 0.0, 0.0, None
        self.border, self.inside = 0.0, False

    def start(self) -> None:
        """Begin at zero torque; force ramps up from here."""
        self._previous = ZERO
        self._active_ticks = 0
        self._ramp = self._ramp_before_gap = 0.0

    def observe(self, tick: int, angle: Pair, age: int, *, homed: bool = True) -> Trip | None:
        """Take a measurement (rad) that is ``age`` ticks old; age 0 is a new one.

        Without ``homed`` the angles have no meaning yet: only their age is checked, and that they
        are numbers.
        """
        self.age = age
        if not (isfinite(angle[0]) and isfinite(angle[1])):
            return Trip(Cause.MEASUREMENT, "the measured joint angle is not a number")
        if age >= self.ticks.drop:
            return Trip(Cause.STALE, f"no valid sample for {age} ticks")
        if age > 0 or not homed:
            return None
        jump = self._jump(tick, angle)
        self._angle = (tick, angle)
        if jump is not None:
            return jump
        self.tip = self.linkage.tip(angle)
        if self.tip is None:
            self.inside = False
            return Trip(
                Cause.MEASUREMENT,
                f"the links cannot meet at joint angles {angle[0]:.3f} and {angle[1]:.3f} rad: "
                "the homing or the device file is wrong",
            )
        spare = self.linkage.dexterity(angle, self.tip) / self.limits.dexterity - 1.0
        self.border = min(
            1.0, self.region.margin(self.tip) / BORDER_METRES, spare / BORDER_DEXTERITY
        )
        self.inside = self.border > (0.0 if self.inside else REENTRY_SHARE)
        return self._speed(tick, self.tip)

    def rest(self) -> str | None:
        """Why the handle cannot be called resting and inside yet, or ``None`` where it is."""
        seen, window = (self._trace[-1][0] - self._trace[0][0] if self._trace else 0), self.ticks
        full = window.speed_window - window.hold
        if seen < full or len(self._trace) < window.speed_window // 2:
            return f"too little of its motion was observed ({len(self._trace)} samples)"
        if not self.inside:
            return "the tip is outside the workspace, or at its border"
        if self.tip_speed > ACTIVATION_TIP_SPEED:
            return f"the tip moves at {self.tip_speed:.3f} m/s, it has to rest"
        return None

    def limit(self, tick: int, command: Pair) -> Decision:
        """The torque (N.m) that may be sent at this tick."""
        del tick
        first = self._active_ticks == 0
        self._active_ticks += 1
        if not (isfinite(command[0]) and isfinite(command[1])):
            return self._stop(
                Cause.COMMAND, Flag.NOT_A_NUMBER, "the torque command is not a number"
            )
        if self.age >= self.ticks.drop:
            return self._stop(Cause.STALE, Flag.AGED, f"no valid sample for {self.age} ticks")
        largest = max(abs(command[0]), abs(command[1]))
        if first and largest >= FIRST_COMMAND_SHARE * self.limits.torque:
            return self._stop(
                Cause.FIRST_COMMAND,
                Flag.TORQUE_LIMIT,
                f"the first command after activation is {largest:.3g} N.m, which is not below "
                f"{FIRST_COMMAND_SHARE:.0%} of the limit {self.limits.torque:.3g} N.m",
            )
        scale, flags = self._scale()
        if scale == 0.0:
            self._previous = ZERO
            self._warm(ZERO)
            return Decision(ZERO, flags)
        first_joint, flags = self._joint(0, command[0] * scale, flags)
        second_joint, flags = self._joint(1, command[1] * scale, flags)
        torque = (first_joint, second_joint)
        self._previous = torque
        self._warm(torque)
        return Decision(torque, flags)

    def _stop(self, cause: Cause, flags: Flag, sentence: str) -> Decision:
        self._previous = ZERO
        return Decision(ZERO, flags, Trip(cause, sentence))

    def _scale(self) -> tuple[float, Flag]:
        """What both joints' torques are multiplied by, so that the force keeps its direction."""
        flags = self._advance_ramp()
        scale = self._ramp
        if self.fastest > FADE_SHARE * self.limits.tip_speed:
            over = self.fastest / self.limits.tip_speed - FADE_SHARE
            scale *= max(0.0, 1.0 - over / (1.0 - FADE_SHARE))
            flags |= Flag.SPEED_LIMIT
        if not self.inside:
            return 0.0, flags | Flag.OUTSIDE_WORKSPACE
        if self.border < 1.0:
            scale, flags = scale * self.border, flags | Flag.NEAR_BORDER
        return scale, flags

    def _advance_ramp(self) -> Flag:
        """One tick further up; down with the age of the data; to nothing outside."""
        hold, drop = self.ticks.hold, self.ticks.drop
        if not self.inside:
            self._ramp = self._ramp_before_gap = 0.0
            return Flag.NONE
        if self.age > hold:
            self._ramp = self._ramp_before_gap * (drop - self.age) / (drop - hold)
            return Flag.AGED
        self._ramp = min(1.0, self._ramp + self.tick / self.limits.ramp_time)
        self._ramp_before_gap = self._ramp
        return Flag.RAMPING if self._ramp < 1.0 else Flag.NONE

    def _joint(self, index: int, torque: float, flags: Flag) -> tuple[float, Flag]:
        size, sign = abs(torque), copysign(1.0, torque)
        if size > self.limits.torque:
            size, flags = self.limits.torque, flags | Flag.TORQUE_LIMIT
        warm = self._warm_limit(index)
        if size > warm:
            size, flags = warm, flags | Flag.HEAT_LIMIT
        before = self._previous[index] * sign
        slewed = max(before, 0.0) + self.limits.slew * self.tick
        if size > slewed:
            size, flags = slewed, flags | Flag.SLEW_LIMIT
        return sign * size, flags

    def _warm(self, torque: Pair) -> None:
        """Integrate the heat above what the motor sheds: I2t in units of (N.m)^2 s."""
        shed = self.limits.continuous_torque**2
        for index in (0, 1):
            heat = self._heat[index] + (torque[index] ** 2 - shed) * self.tick
            self._heat[index] = max(0.0, heat)

    def _warm_limit(self, index: int) -> float:
        """Largest torque at the present heat; it fades so that the hand feels no step."""
        low, high = min(self.limits.continuous_torque, self.limits.torque), self.limits.torque
        budget = (high**2 - low**2) * self.limits.peak_time
        if budget <= 0.0:
            return low
        spent = self._heat[index] / budget
        if spent <= FADE_SHARE:
            return high
        left = max(0.0, (1.0 - spent) / (1.0 - FADE_SHARE))
        return low + (high - low) * left

    def _jump(self, tick: int, angle: Pair) -> Trip | None:
        if self._angle is None:
            return None
        since, before = self._angle
        ticks = max(1, tick - since)
        allowed = self.limits.joint_speed * ticks * self.tick + QUANTA * self.quantum
        largest = max(abs(angle[0] - before[0]), abs(angle[1] - before[1]))
        if largest <= allowed:
            return None
        return Trip(
            Cause.JUMP,
            f"a joint angle jumped by {largest:.3g} rad in {ticks} ticks, more than "
            f"{self.limits.joint_speed:.3g} rad/s allows",
        )

    def _speed(self, tick: int, tip: Pair) -> Trip | None:
        self._trace.append((tick, tip))
        window, recently = self.ticks.speed_window, self.ticks.vibration
        while len(self._trace) > 2 and tick - self._trace[0][0] > window:
            self._trace.popleft()
        since, start = self._trace[0]
        if tick - since >= window // 2:
            self.tip_speed = self._chord(tick, tip, since, start)
        recent = self._trace[max(0, len(self._trace) - 1 - recently)]
        self.fastest = self.tip_speed
        if tick - recent[0] >= recently:
            self.fastest = max(self.fastest, self._chord(tick, tip, *recent))
        if self.fastest < self.limits.tip_speed:
            return None
        return Trip(
            Cause.SPEED,
            f"the tip moves at {self.fastest:.2f} m/s, the limit is "
            f"{self.limits.tip_speed:.2f} m/s",
        )

    def _chord(self, tick: int, tip: Pair, since: int, start: Pair) -> float:
        """Speed (m/s) from one place to another, straight."""
        return hypot(tip[0] - start[0], tip[1] - start[1]) / ((tick - since) * self.tick)
