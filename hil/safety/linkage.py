"""The five-bar linkage as the safety layer needs it: where the tip is, and if that makes sense.

Motors at (0, 0) and (base, 0), proximal and distal links, tip above the line between the elbows.
Source: G. Campion, Q. Wang and V. Hayward, "The Pantograph Mk-II", IROS 2005; thesis section 7.1.
Plain floats, because this runs every tick beside a device's exchange.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, atan2, cos, hypot, nan, pi, sin, sqrt

Pair = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Region:
    """A rectangle in the device's frame (m): where the tip is allowed to be."""

    left: float
    right: float
    bottom: float
    top: float

    def is_within(self, other: Region) -> bool:
        """Whether it is a part of another one."""
        return other.contains((self.left, self.bottom)) and other.contains((self.right, self.top))

    def contains(self, point: Pair) -> bool:
        """Whether a point is inside or on the edge."""
        return self.margin(point) >= 0.0

    def margin(self, point: Pair) -> float:
        """Distance to the nearest edge (m), below zero outside."""
        x, y = point
        return min(x - self.left, self.right - x, y - self.bottom, self.top - y)


@dataclass(frozen=True, slots=True, kw_only=True)
class Linkage:
    """Link lengths and motor distance (m)."""

    proximal: float
    distal: float
    base: float

    def tip(self, angle: Pair) -> Pair | None:
        """Tip position (m) in the device's frame, or ``None`` where the links cannot meet."""
        ax, ay = self.proximal * cos(angle[0]), self.proximal * sin(angle[0])
        dx = self.base + self.proximal * cos(angle[1]) - ax
        dy = self.proximal * sin(angle[1]) - ay
        gap = hypot(dx, dy)
        room = self.distal**2 - gap * gap / 4
        if not (gap > 1e-9 and room >= 0.0):
            return None
        height = sqrt(room) / gap
        return ax + dx / 2 - dy * height, ay + dy / 2 + dx * height

    def angles(self, tip: Pair) -> Pair | None:
        """Joint angles (rad, 0 to 2 pi, elbows outward) for a tip position (m), where reachable."""
        found: list[float] = []
        for axis, side in ((0.0, 1.0), (self.base, -1.0)):
            x, y = tip[0] - axis, tip[1]
            reach = hypot(x, y)
            if reach < 1e-9:
                return None
            cosine = (self.proximal**2 + reach**2 - self.distal**2) / (2 * self.proximal * reach)
            if abs(cosine) > 1.0:
                return None
            found.append((atan2(y, x) + side * acos(cosine)) % (2 * pi))
        return found[0], found[1]

    def tip_force(self, angle: Pair, torque: Pair) -> Pair:
        """Force at the tip (N) that joint torques (N.m) give: torque = J^T force.

        The Jacobian is taken by differences; (nan, nan) where the linkage has none.
        """
        step = 1e-6
        tips = (
            self.tip((angle[0] + step, angle[1])),
            self.tip((angle[0] - step, angle[1])),
            self.tip((angle[0], angle[1] + step)),
            self.tip((angle[0], angle[1] - step)),
        )
        ahead_1, back_1, ahead_2, back_2 = tips
        if ahead_1 is None or back_1 is None or ahead_2 is None or back_2 is None:
            return nan, nan
        a, c = ((ahead_1[i] - back_1[i]) / (2 * step) for i in (0, 1))
        b, d = ((ahead_2[i] - back_2[i]) / (2 * step) for i in (0, 1))
        area = a * d - b * c
        if area == 0.0:
            return nan, nan
        return (d * torque[0] - c * torque[1]) / area, (a * torque[1] - b * torque[0]) / area

    def dexterity(self, angle: Pair, tip: Pair) -> float:
        """How far from a singular position: the least of three sines, 0 (singular) to 1.

        They are the angle between the distal links, and between each distal link and its proximal
        one; at zero of the first the tip's force is unbounded, at zero of the others a motor's
        torque moves nothing.
        """
        a = (self.proximal * cos(angle[0]), self.proximal * sin(angle[0]))
        b = (self.base + self.proximal * cos(angle[1]), self.proximal * sin(angle[1]))
        u1 = ((tip[0] - a[0]) / self.distal, (tip[1] - a[1]) / self.distal)
        u2 = ((tip[0] - b[0]) / self.distal, (tip[1] - b[1]) / self.distal)
        between = abs(u1[0] * u2[1] - u1[1] * u2[0])
        first = abs(-u1[0] * sin(angle[0]) + u1[1] * cos(angle[0]))
        second = abs(-u2[0] * sin(angle[1]) + u2[1] * cos(angle[1]))
        return min(between, first, second)

    def default_region(self) -> Region:
        """A rectangle in front of the motors that stays clear of the linkage's outer reach."""
        reach = self.proximal + self.distal
        middle = self.base / 2
        return Region(
            left=middle - 0.5 * reach,
            right=middle + 0.5 * reach,
            bottom=0.25 * reach,
            top=0.97 * reach,
        )
