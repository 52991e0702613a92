"""Which part of the world a picture shows, and where in it a place lies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import cos, sin
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.render.poses import Poses

MARGIN = 0.03
"""Metres around what moves."""
EMPTY = np.array([[-0.2, -0.2], [0.2, 0.2]])
"""What is shown where nothing is anywhere (m)."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class View:
    """Middle of the scene (m), pixels in a metre, the picture's size and its title's height."""

    x: float
    y: float
    scale: float
    size: tuple[int, int]
    title: int = 0

    def at(self, point: Sequence[float]) -> Point:
        """The pixel of a place in the world; y is up there and down here."""
        width, height = self.size
        return (
            width / 2 + (point[0] - self.x) * self.scale,
            (height + self.title) / 2 - (point[1] - self.y) * self.scale,
        )


def view_of(scene: Mapping[str, Any], poses: Poses, size: tuple[int, int], title: int = 0) -> View:
    """A view that holds everything that moves, in all frames, below a title of some pixels."""
    places: list[NDArray[np.float64]] = []
    for box in scene["boxes"]:
        found = poses.pair(box["pose"])
        if found is not None:
            places += [found - 0.75 * box["side"], found + 0.75 * box["side"]]
    for finger in scene["fingers"]:
        found = poses.pair(finger["position"])
        if found is not None:
            places.append(found)
        if finger["device"] is not None:
            places.append(np.array([finger["device"]["base"][:2]]))
    for body in scene["bodies"]:
        found = poses.one(body["position"])
        if found is not None:
            places.append(np.stack([found, np.zeros_like(found)], axis=1))
            places += [places[-1] - 0.1, places[-1] + 0.1]
    every = np.concatenate([EMPTY[:0], *places])
    every = every[np.isfinite(every).all(axis=1)]
    every = every if len(every) else EMPTY
    low, high = every.min(axis=0) - MARGIN, every.max(axis=0) + MARGIN
    scale = min(size[0] / (high[0] - low[0]), (size[1] - title) / (high[1] - low[1]))
    middle = (low + high) / 2
    return View(float(middle[0]), float(middle[1]), float(scale), size, title)


def corners(place: Sequence[float], angle: float, side: float) -> list[Point]:
    """Of a square (m) that is turned by an angle (rad) about its place, all the way round."""
    c, s, h = cos(angle), sin(angle), side / 2
    turned = ((-h, -h), (h, -h), (h, h), (-h, h))
    return [(place[0] + c * u - s * v, place[1] + s * u + c * v) for u, v in turned]
