"""One frame: the scene drawn with Pillow, at twice its size and then halved for smooth edges.

It looks as the live page does (``cosim/live/page/scene.js``): the first copy of the box whole, the
others as ghosts, fingers by contact state, forces to scale.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from importlib import import_module
from math import atan2, ceil, cos, hypot, isfinite, sin
from typing import Any

import numpy as np

from cosim.render.colours import Colour, colours, mixed
from cosim.render.poses import Poses
from cosim.render.view import Point, corners, view_of

OVERSAMPLED = 2
FORCE_SCALE = 0.02
"""Metres drawn for a newton."""
TRAIL = 1.5
"""Seconds that a trail goes back."""
BODIES = 0.16
"""Height (m) over which the bodies of a single axis are spread ..."""
BODY_ROW = 24
"""... and the least that each has (pixels)."""
BESIDE = ((0, -18), (0, 18), (22, 0), (-22, 0))
"""Pixels from a finger to its name, in the order in which places are tried."""
NAME_SIZE = (20.0, 17.0)
"""Pixels that a name and a finger need."""
GRID = 0.05
TITLE = 26
"""Pixels that a title takes."""
WEAK = 0.02
"""Force (N) from which there is an arrow."""
FREE, FIRST_TOUCH, SLIDING = 0, 1, 3

Places = Sequence[Sequence[float]]


class Painter:
    """Draws the frames of one run."""

    def __init__(
        self,
        scene: Mapping[str, Any],
        poses: Poses,
        size: tuple[int, int],
        *,
        scheme: str = "light",
        title: str = "",
    ) -> None:
        """``size`` in pixels; ``scheme`` is light or dark; ``title`` stands above the scene."""
        self._scene, self._poses, self._title = scene, poses, title
        self._size = size
        self._colours = colours(scheme)
        wide, high = (OVERSAMPLED * side for side in size)
        self._view = view_of(scene, poses, (wide, high), TITLE * OVERSAMPLED if title else 0)
        fonts: Any = import_module("PIL.ImageFont")
        self._font = fonts.load_default(13 * OVERSAMPLED)
        self._small = fonts.load_default(11 * OVERSAMPLED)
        things = (*scene["boxes"], *scene["fingers"])
        stations = list(dict.fromkeys(each["station"] for each in things))
        self._number = {station: number for number, station in enumerate(stations)}

    def frame(self, number: int) -> Any:
        """A Pillow image, RGB, of one of the poses."""
        images: Any = import_module("PIL.Image")
        image = images.new("RGB", self._view.size, self._colours["ground"])
        pen = import_module("PIL.ImageDraw").Draw(image)
        self._grid(pen)
        for wall in self._scene["walls"]:
            self._wall(pen, wall)
        boxes, fingers = (self._in_use(self._scene[what], number) for what in ("boxes", "fingers"))
        for box in boxes[1:]:
            self._box(pen, box, number, is_ghost=True)
        for box in boxes[:1]:
            self._box(pen, box, number, is_ghost=False)
        for finger in fingers:
            self._linkage(pen, finger, number)
        for each in (*fingers, *boxes):
            self._trail(pen, each, number)
        for finger in fingers:
            self._finger(pen, finger, number)
        self._names(pen, fingers, number)
        for order, body in enumerate(self._scene["bodies"]):
            self._body(pen, body, order, number)
        self._text(pen, number)
        return image.reduce(OVERSAMPLED)

    def _in_use(self, things: Sequence[Mapping[str, Any]], number: int) -> list[Mapping[str, Any]]:
        """Of two worlds beside each other the one whose torques are passed on in a frame."""
        found: list[Mapping[str, Any]] = []
        for thing in things:
            share = self._poses.one(thing.get("share"))
            second = share is not None and bool(share[number] >= 0.5)
            if thing.get("world", 0) == int(second):
                found.append(thing)
        return found

    def _user(self, station: str) -> Colour:
        return self._colours[f"user-{self._number.get(station, 0) % 4}"]

    def _soft(self, colour: Colour, share: float) -> Colour:
        return mixed(colour, self._colours["ground"], share)

    def _line(self, pen: Any, points: Places, colour: Colour, width: float) -> None:
        at = [self._view.at(point) for point in points]
        pen.line(at, fill=colour, width=max(1, round(width * OVERSAMPLED)), joint="curve")

    def _dashed(self, pen: Any, points: Places, colour: Colour, width: float) -> None:
        dash, gap = 7 * OVERSAMPLED, 5 * OVERSAMPLED
        for (x, y), (u, v) in zip(
            (self._view.at(p) for p in points), (self._view.at(p) for p in points[1:]), strict=False
        ):
            length = hypot(u - x, v - y)
            for start in np.arange(0.0, length, dash + gap):
                end = min(length, start + dash)
                ends = [(x + (u - x) * s / length, y + (v - y) * s / length) for s in (start, end)]
                pen.line(ends, fill=colour, width=round(width * OVERSAMPLED))

    def _dot(self, pen: Any, point: Sequence[float], radius: float, colour: Colour) -> None:
        x, y = self._view.at(point)
        r = radius * OVERSAMPLED
        pen.ellipse((x - r, y - r, x + r, y + r), fill=colour)

    def _grid(self, pen: Any) -> None:
        view, faint = self._view, self._colours["faint"]
        half = (view.size[0] / 2 / view.scale, view.size[1] / 2 / view.scale)
        for axis, middle in enumerate((view.x, view.y)):
            first = ceil((middle - half[axis]) / GRID)
            for step in range(first, ceil((middle + half[axis]) / GRID)):
                at = step * GRID
                ends = (
                    [(at, view.y - half[1]), (at, view.y + half[1])],
                    [(view.x - half[0], at), (view.x + half[0], at)],
                )[axis]
                self._line(pen, ends, faint, 0.5)

    def _wall(self, pen: Any, wall: Sequence[float]) -> None:
        x, y, nx, ny = wall
        size = hypot(nx, ny) or 1.0
        nx, ny = nx / size, ny / size
        tx, ty = -ny, nx
        ink = self._colours["ink"]
        self._line(pen, [(x - 2 * tx, y - 2 * ty), (x + 2 * tx, y + 2 * ty)], ink, 3)
        for step in range(-130, 130):
            px, py = x + 0.015 * step * tx, y + 0.015 * step * ty
            self._line(pen, [(px, py), (px - 0.012 * (nx + tx), py - 0.012 * (ny + ty))], ink, 1)

    def _box(self, pen: Any, box: Mapping[str, Any], number: int, *, is_ghost: bool) -> None:
        place, angle = self._poses.pair(box["pose"]), self._poses.one(box["pose"][2])
        if place is None or angle is None or not np.isfinite(place[number]).all():
            return
        outline = self._nodes(box, number) or corners(place[number], angle[number], box["side"])
        if not np.isfinite(outline).all():
            return
        colour = self._user(box["station"])
        closed = [*outline, outline[0]]
        if is_ghost:
            self._dashed(pen, closed, colour, 1.5)
            return
        pen.polygon([self._view.at(p) for p in outline], fill=self._soft(colour, 0.16))
        self._line(pen, closed, colour, 2)

    def _nodes(self, box: Mapping[str, Any], number: int) -> list[Point] | None:
        """The outline of a soft object: the outer ones of its 3 x 3 nodes."""
        names: Sequence[str] = box["nodes"]
        found = [self._poses.one(name) for name in names]
        if len(found) != 18 or any(each is None for each in found):
            return None
        flat = [float(each[number]) for each in found if each is not None]
        return [(flat[2 * i], flat[2 * i + 1]) for i in (0, 1, 2, 5, 8, 7, 6, 3)]

    def _linkage(self, pen: Any, finger: Mapping[str, Any], number: int) -> None:
        device: Mapping[str, Any] | None = finger["device"]
        tip = self._poses.pair(finger["position"])
        angles = None if device is None else self._poses.pair(device["angles"])
        if device is None or tip is None or angles is None:
            return
        if not np.isfinite([*tip[number], *angles[number]]).all():
            return
        x, y, turn = device["base"]
        colour = self._soft(self._user(finger["station"]), 0.35)
        motors = ((x, y), (x + device["distance"] * cos(turn), y + device["distance"] * sin(turn)))
        for (mx, my), angle in zip(motors, angles[number], strict=True):
            length = device["proximal"]
            elbow = (mx + length * cos(turn + angle), my + length * sin(turn + angle))
            self._line(pen, [(mx, my), elbow], colour, 4)
            self._line(pen, [elbow, tip[number]], colour, 2.5)
            self._dot(pen, (mx, my), 6, colour)
            self._dot(pen, elbow, 3.5, colour)

    def _trail(self, pen: Any, each: Mapping[str, Any], number: int) -> None:
        places = self._poses.pair(each.get("position") or each.get("pose"))
        if places is None:
            return
        times = self._poses.times
        first = int(np.searchsorted(times, float(times[number]) - TRAIL))
        way = places[first : number + 1]
        ends = zip(way[:, 0], way[:, 1], strict=True)
        known: list[Point] = [(x, y) for x, y in ends if isfinite(x) and isfinite(y)]
        if len(known) > 1:
            self._line(pen, known, self._soft(self._user(each["station"]), 0.55), 1.2)

    def _finger(self, pen: Any, finger: Mapping[str, Any], number: int) -> None:
        places = self._poses.pair(finger["position"])
        if places is None or not np.isfinite(places[number]).all():
            return
        colour, (x, y) = self._user(finger["station"]), places[number]
        forces = self._poses.pair(finger["force"])
        size = 0.0 if forces is None else hypot(*forces[number])
        if forces is not None and isfinite(size) and size > WEAK:
            self._arrow(pen, (x, y), forces[number], colour)
        states = self._poses.one(finger["state"])
        told = math.nan if states is None else states[number]
        state = int(told) if isfinite(told) else 2 if size > WEAK else FREE
        slide = self._colours["slide"]
        rim = slide if state == SLIDING else colour
        self._dot(pen, (x, y), 9, rim)
        if state in {FREE, FIRST_TOUCH}:
            self._dot(pen, (x, y), 6.5, self._colours["ground"])

    def _names(self, pen: Any, fingers: Sequence[Mapping[str, Any]], number: int) -> None:
        """Each finger's name beside it, where no other finger, name or arrow is."""
        shown: list[tuple[str, Point]] = []
        arrows: list[Point] = []
        for finger in fingers:
            places = self._poses.pair(finger["position"])
            if places is not None and np.isfinite(places[number]).all():
                name = f"{finger['station'].removeprefix('station_')}{finger['finger']}"
                shown.append((name, self._view.at(places[number])))
                forces = self._poses.pair(finger["force"])
                if forces is not None and WEAK < hypot(*forces[number]) < math.inf:
                    half = places[number] + 0.5 * FORCE_SCALE * forces[number]
                    arrows.append(self._view.at(half))
        taken = [*(place for _, place in shown), *arrows]
        for name, (x, y) in shown:
            beside = [(x + dx * OVERSAMPLED, y + dy * OVERSAMPLED) for dx, dy in BESIDE]
            free = (p for p in beside if all(_are_apart(p, other) for other in taken))
            place = next(free, beside[0])
            taken.append(place)
            pen.text(
                place,
                name,
                self._colours["ink"],
                font=self._small,
                anchor="mm",
                stroke_width=2 * OVERSAMPLED,
                stroke_fill=self._colours["ground"],
            )

    def _arrow(self, pen: Any, start: Point, force: Sequence[float], colour: Colour) -> None:
        end = (start[0] + FORCE_SCALE * force[0], start[1] + FORCE_SCALE * force[1])
        self._line(pen, [start, end], colour, 3)
        x, y = self._view.at(end)
        angle, r = atan2(-force[1], force[0]), 8 * OVERSAMPLED
        pen.polygon(
            [(x + r * cos(angle + turn), y + r * sin(angle + turn)) for turn in (0.0, 2.5, -2.5)],
            fill=colour,
        )

    def _body(self, pen: Any, body: Mapping[str, Any], order: int, number: int) -> None:
        places = self._poses.one(body["position"])
        if places is None or not isfinite(places[number]):
            return
        count = len(self._scene["bodies"])
        # Below one another, however far they go and so however few pixels a metre has.
        row = max(BODIES / count * self._view.scale, BODY_ROW * OVERSAMPLED)
        px, middle = self._view.at((places[number], 0.0))
        py = middle + (order + 0.5 - count / 2) * row
        w, h = 12 * OVERSAMPLED, 9 * OVERSAMPLED
        pen.rectangle((px - w, py - h, px + w, py + h), fill=self._colours[f"user-{order % 4}"])
        where = (px + 1.5 * w, py)
        pen.text(where, body["name"], self._colours["ink"], font=self._small, anchor="lm")

    def _text(self, pen: Any, number: int) -> None:
        ink, edge = self._colours["ink"], 12 * OVERSAMPLED
        if self._title:
            pen.text((edge, edge), self._title, ink, font=self._font)
        width, height = self._view.size
        said = f"{self._poses.times[number]:.2f} s"
        pen.text((width - edge, height - edge), said, ink, font=self._font, anchor="rs")
        rows = [(GRID, "5 cm")] + ([(FORCE_SCALE, "1 N")] if self._scene["fingers"] else [])
        for order, (length, text) in enumerate(rows):
            y = height - edge - 20 * OVERSAMPLED * order
            end = edge + length * self._view.scale
            pen.line([(edge, y), (end, y)], fill=ink, width=2 * OVERSAMPLED)
            pen.text((end + 8 * OVERSAMPLED, y), text, ink, font=self._small, anchor="lm")


def _are_apart(one: Point, other: Point) -> bool:
    across, up = (abs(a - b) / OVERSAMPLED for a, b in zip(one, other, strict=True))
    return across > NAME_SIZE[0] or up > NAME_SIZE[1]
