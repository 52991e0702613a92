"""The schema of the scene's messages, whole: viewers build their types from it.

A list without the type of its items, or an object without its properties, is refused by them, and
the topic with it; so the lists that stay empty here have a type of item, too.
"""

from __future__ import annotations

import json
from typing import Any

from cosim.base.foxglove.entities import KINDS

NAME = "foxglove.SceneUpdate"


def scene_schema() -> bytes:
    """JSON Schema of a message of ``cosim.base.foxglove.entities``."""
    return json.dumps({"title": NAME, **_object(deletions=_DELETIONS, entities=_ENTITIES)}).encode()


def _object(**properties: Any) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _list_of(item: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": item}


_NUMBER = {"type": "number"}
_TEXT = {"type": "string"}
_TIME = _object(sec={"type": "integer"}, nsec={"type": "integer"})
_VECTOR = _object(**dict.fromkeys("xyz", _NUMBER))
_POSE = _object(position=_VECTOR, orientation=_object(**dict.fromkeys("xyzw", _NUMBER)))
_COLOUR = _object(**dict.fromkeys("rgba", _NUMBER))
_ARROW_LENGTHS = ("shaft_length", "shaft_diameter", "head_length", "head_diameter")
_SHAPES = {
    "metadata": _object(key=_TEXT, value=_TEXT),
    "arrows": _object(pose=_POSE, **dict.fromkeys(_ARROW_LENGTHS, _NUMBER), color=_COLOUR),
    "cubes": _object(pose=_POSE, size=_VECTOR, color=_COLOUR),
    "spheres": _object(pose=_POSE, size=_VECTOR, color=_COLOUR),
}
_NEVER_SENT = _object(pose=_POSE)
_ENTITIES = _list_of(
    _object(
        timestamp=_TIME,
        frame_id=_TEXT,
        id=_TEXT,
        lifetime=_TIME,
        frame_locked={"type": "boolean"},
        **{kind: _list_of(_SHAPES.get(kind, _NEVER_SENT)) for kind in KINDS},
    )
)
_DELETIONS = _list_of(_object(timestamp=_TIME, type={"type": "integer"}, id=_TEXT))
