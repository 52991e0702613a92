"""The limits that an excitation has to keep, and what of them a trajectory uses.

They are the safety layer's, as a device file states them; a share is left for what the device is
other than thought. Where the layer would cut in, torque would no longer be what was planned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cosim.identification.five_bar import Array, FiveBar
from cosim.identification.regressor import torques

SHARE = 0.8
"""Of torque, slew, tip speed and joint speed that is used: beyond it speed fades torque."""
HEAT_SHARE = 0.9
"""Of the continuous torque that the mean square may reach."""
BORDER = 0.008
"""Metres kept from the workspace's border: force fades over the last 5 mm."""
DEXTERITY_SPARE = 1.3
"""Times the least dexterity: force fades below 1.2."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Envelope:
    """A device's limits (SI units) with its geometry; ``region`` is left, right, bottom, top."""

    bar: FiveBar
    torque: float
    continuous_torque: float
    slew: float
    tip_speed: float
    joint_speed: float
    dexterity: float
    region: tuple[float, float, float, float]

    def keeps_inside(self, angle: Array) -> bool:
        """Whether every pose (samples, 2) is away from border and singular positions."""
        tip = self.bar.tip(angle)
        left, right, bottom, top = self.region
        margin = np.min(
            [tip[:, 0] - left, right - tip[:, 0], tip[:, 1] - bottom, top - tip[:, 1]], axis=0
        )
        # A place out of reach is NaN, which is no margin.
        inside = bool(np.all(margin >= BORDER))
        return inside and bool(
            np.all(self.bar.dexterity(angle) >= DEXTERITY_SPARE * self.dexterity)
        )

    def use(
        self, motion: tuple[Array, Array, Array], values: Array, tick: float
    ) -> dict[str, float]:
        """The largest share of each limit that a motion takes; 1 is all that is allowed here."""
        angle, rate, acceleration = motion
        needed = torques(self.bar, angle, rate, acceleration) @ values
        # Friction changes sides at once, which is the friction's doing and not the motor's.
        smooth = torques(self.bar, angle, rate, acceleration)[:, :, :5] @ values[:5]
        moved = self.bar.motion(angle, rate, acceleration)
        speed = np.hypot(moved.tip_velocity[:, 0], moved.tip_velocity[:, 1])
        grows = np.abs(np.diff(smooth, axis=0)) / tick
        heat = float(np.sqrt(np.max(np.mean(needed**2, axis=0))))
        return {
            "torque": float(np.max(np.abs(needed))) / (SHARE * self.torque),
            "continuous_torque": heat / (HEAT_SHARE * self.continuous_torque),
            "slew": float(np.max(grows)) / (SHARE * self.slew),
            "tip_speed": float(np.max(speed)) / (SHARE * self.tip_speed),
            "joint_speed": float(np.max(np.abs(rate))) / (SHARE * self.joint_speed),
        }
