"""Slow, plain NumPy versions of what the C models compute, written from the geometry alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fmus.development import Instance
from fmus.shared.mechanism.device import presets

T = 1 / 1024
Array = NDArray[np.float64]

IDEAL_DEVICE = {
    "dac_bits": 0,
    "encoder_counts": 0,
    "coulomb_friction": 0.0,
    "viscous_friction": 0.0,
    "amplifier_bandwidth": 0.0,
}


@dataclass(frozen=True)
class FiveBar:
    """Links l, L and base distance d (m), placed at ``origin`` under ``angle`` in the world."""

    proximal: float
    distal: float
    base: float
    origin: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.0

    @property
    def rotation(self) -> Array:
        c, s = np.cos(self.angle), np.sin(self.angle)
        return np.array([[c, -s], [s, c]])

    def elbows(self, joints: Array) -> tuple[Array, Array]:
        """Elbow positions (m) in the device's frame."""
        a = self.proximal * np.array([np.cos(joints[0]), np.sin(joints[0])])
        b = self.proximal * np.array([np.cos(joints[1]), np.sin(joints[1])])
        b[0] += self.base
        return a, b

    def tip(self, joints: Array) -> Array:
        """Tip position (m) in the device's frame: the intersection of two circles."""
        a, b = self.elbows(joints)
        middle, half = (a + b) / 2, (b - a) / 2
        height = np.sqrt(self.distal**2 - half @ half)
        return middle + height * np.array([-half[1], half[0]]) / np.linalg.norm(half)

    def world(self, joints: Array) -> Array:
        """Tip position (m) in the world."""
        return np.array(self.origin) + self.rotation @ self.tip(joints)

    def joints(self, world: Any) -> Array:
        """Joint angles (rad) that put the tip at a world position."""
        x, y = self.rotation.T @ (np.asarray(world) - self.origin)
        found: list[float] = []
        for axis, side in ((0.0, 1.0), (self.base, -1.0)):
            r = np.hypot(x - axis, y)
            opening = np.arccos(
                (self.proximal**2 + r**2 - self.distal**2) / (2 * self.proximal * r)
            )
            found.append(float(np.arctan2(y, x - axis) + side * opening))
        return np.array(found)

    def jacobian(self, joints: Array, step: float = 1e-6) -> Array:
        """d tip / d joints in the device's frame by central differences (m/rad)."""
        columns = [
            (self.tip(joints + e) - self.tip(joints - e)) / (2 * step) for e in step * np.eye(2)
        ]
        return np.array(columns).T


def preset_bar(
    device: int, origin: tuple[float, float] = (0.0, 0.0), angle: float = 0.0
) -> FiveBar:
    """The five-bar of a device preset (0 Quanser-like, 1 Haply-like)."""
    values = presets("GEOMETRY")
    return FiveBar(
        values["proximal_length"][device],
        values["distal_length"][device],
        values["base_distance"][device],
        origin,
        angle,
    )


class Bench:
    """A workstation model whose fingers are put at world positions (m), read ideally.

    Each finger has a Quanser-like device placed so that ``centre`` (m) lies in the middle of its
    workspace, turned by ``angle`` (rad).
    """

    def __init__(
        self,
        model: str,
        centres: list[tuple[float, float]],
        angles: list[float] | None = None,
        **parameters: Any,
    ) -> None:
        angles = angles or [0.0] * len(centres)
        self.bars: list[FiveBar] = []
        values: dict[str, Any] = {
            "fingers": len(centres),
            "velocity_estimator": 1,
            "velocity_window": 1,
        }
        for number, (centre, angle) in enumerate(zip(centres, angles, strict=True), start=1):
            bar = preset_bar(0, angle=angle)
            origin = np.array(centre) - bar.rotation @ np.array([bar.base / 2, 0.19])
            bar = preset_bar(0, (float(origin[0]), float(origin[1])), angle)
            self.bars.append(bar)
            values[f"finger_{number}.base_x"], values[f"finger_{number}.base_y"] = bar.origin
            values[f"finger_{number}.base_angle"] = angle
            values[f"finger_{number}.encoder_counts"] = 0
            values[f"finger_{number}.max_force"] = 1e6
        self.instance = Instance(model, **{**values, **parameters})
        self.instance.initialise()

    def put(self, *positions: Any) -> None:
        """Put the fingers at world positions (m)."""
        for number, (bar, position) in enumerate(zip(self.bars, positions, strict=True), start=1):
            self.instance[f"finger_{number}.joint_angle"] = bar.joints(position)

    def step(self) -> None:
        """One control period."""
        self.instance.step(T)

    def planar(self, name: str) -> Array:
        """The members x, y, theta of a group."""
        return np.array([self.instance[f"{name}.{axis}"] for axis in ("x", "y", "theta")])

    def __getitem__(self, name: str) -> Any:
        return self.instance[name]

    def __setitem__(self, name: str, value: Any) -> None:
        self.instance[name] = value
