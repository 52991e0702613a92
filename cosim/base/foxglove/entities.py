"""The scene of a run as entities of Foxglove (``foxglove.SceneUpdate``, encoded as JSON).

Boxes and bodies are cubes, fingers are spheres with an arrow for the force on them, walls are thin
cubes; lengths in m, in the frame ``world``, x and y as in the run and z towards who looks on.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

TOPIC = "/scene"
RATE = 32
"""Scenes a second, as the display of the thesis."""
METRES_A_NEWTON = 0.02
LEAST_FORCE = 0.02
"""Newton from which a force has an arrow."""
FINGER = 0.012
ROW = 0.06
"""Metres between the bodies of a single axis."""
WALL = (0.004, 1.0)
FRAME = "world"
COLOURS = ((0.0, 0.39, 0.66), (0.72, 0.26, 0.0), (0.0, 0.44, 0.31), (0.54, 0.23, 0.53))
"""Of the users' stations, as on the pages."""
KINDS = (
    *("metadata", "arrows", "cubes", "spheres", "cylinders"),
    *("lines", "triangles", "texts", "models"),
)
"""Lists of shapes that an entity has; those that stay empty have to be there, too."""
WITH_THAT_NAME = 0
"""``foxglove.SceneEntityDeletionType``: the entity of one id."""


class SceneUpdates:
    """Messages one after the other: what is in one and not in the next is deleted there."""

    def __init__(self, scene: Mapping[str, Any]) -> None:
        """``scene`` as ``cosim.scene`` describes it."""
        self._scene = scene
        self._drawn: set[str] = set()

    def message(self, at: Mapping[str, float], nanoseconds: int) -> dict[str, Any] | None:
        """The scene where the signals have these values; ``None`` where there is nothing.

        Args:
            at: values by recorded signal; what is missing or no number is not drawn.
            nanoseconds: model time.
        """
        stamp = {"sec": nanoseconds // 1_000_000_000, "nsec": nanoseconds % 1_000_000_000}
        entities = list(_entities(self._scene, at, stamp))
        before, self._drawn = self._drawn, {entity["id"] for entity in entities}
        gone = [
            {"timestamp": stamp, "type": WITH_THAT_NAME, "id": name}
            for name in sorted(before - self._drawn)
        ]
        return {"deletions": gone, "entities": entities} if entities or gone else None


def _entities(
    scene: Mapping[str, Any], at: Mapping[str, float], stamp: dict[str, int]
) -> Iterator[dict[str, Any]]:
    things = [*scene["boxes"], *scene["fingers"]]
    stations = list(dict.fromkeys(thing["station"] for thing in things))
    for box in scene["boxes"]:
        pose = _known(box["pose"], at)
        if pose is not None and _is_in_use(box, at):
            colour = _colour(stations.index(box["station"]), 0.6)
            cube = _cube(pose, (box["side"], box["side"], box["side"] / 4), colour)
            yield _entity(f"box {box['name']}", stamp, cubes=[cube])
    for finger in scene["fingers"]:
        place, force = _known(finger["position"], at), _known(finger["force"], at)
        if place is None or not _is_in_use(finger, at):
            continue
        colour = _colour(stations.index(finger["station"]), 1.0)
        ball = {"pose": _pose(*place), "size": _vector(FINGER, FINGER, FINGER), "color": colour}
        arrows = [] if force is None else _arrows(place, force, colour)
        yield _entity(f"finger {finger['name']}", stamp, spheres=[ball], arrows=arrows)
    for order, body in enumerate(scene["bodies"]):
        place = _known([body["position"]], at)
        if place is not None:
            cube = _cube((place[0], -ROW * order, 0.0), (0.04, 0.03, 0.02), _colour(order, 1.0))
            yield _entity(f"body {body['name']}", stamp, cubes=[cube])
    for order, (x, y, across, up) in enumerate(scene["walls"]):
        pose = (x, y, math.atan2(up, across))
        cube = _cube(pose, (*WALL, 0.05), {"r": 0.5, "g": 0.5, "b": 0.5, "a": 0.5})
        yield _entity(f"wall {order + 1}", stamp, cubes=[cube])


def _is_in_use(thing: Mapping[str, Any], at: Mapping[str, float]) -> bool:
    """Of two worlds beside each other, whether it is of the one whose torques are passed on."""
    if "share" not in thing:
        return True
    second = at.get(thing["share"], 0.0) >= 0.5
    return thing["world"] == int(second)


def _known(names: Sequence[str] | None, at: Mapping[str, float]) -> list[float] | None:
    """The values of all of them, or nothing where one is missing or is no number."""
    values = [at.get(name, math.nan) for name in names or ()]
    return values if values and all(map(math.isfinite, values)) else None


def _arrows(
    place: Sequence[float], force: Sequence[float], colour: dict[str, float]
) -> list[dict[str, Any]]:
    size = math.hypot(*force)
    if size < LEAST_FORCE:
        return []
    arrow = {
        "pose": _pose(place[0], place[1], math.atan2(force[1], force[0])),
        "shaft_length": METRES_A_NEWTON * size,
        "shaft_diameter": 0.003,
        "head_length": 0.008,
        "head_diameter": 0.008,
        "color": colour,
    }
    return [arrow]


def _entity(name: str, stamp: dict[str, int], **shapes: list[Any]) -> dict[str, Any]:
    return {
        "timestamp": stamp,
        "frame_id": FRAME,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": False,
        **{kind: shapes.get(kind, []) for kind in KINDS},
    }


def _cube(
    pose: Sequence[float], size: tuple[float, float, float], colour: dict[str, float]
) -> dict[str, Any]:
    return {"pose": _pose(*pose), "size": _vector(*size), "color": colour}


def _pose(x: float, y: float, angle: float = 0.0) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}
    return {"position": _vector(x, y, 0.0), "orientation": turn}


def _vector(x: float, y: float, z: float) -> dict[str, float]:
    return {"x": x, "y": y, "z": z}


def _colour(number: int, alpha: float) -> dict[str, float]:
    red, green, blue = COLOURS[number % len(COLOURS)]
    return {"r": red, "g": green, "b": blue, "a": alpha}
