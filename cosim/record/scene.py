"""What can be drawn of a run, as it lies in its folder (``cosim.scene`` describes it)."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, cast

from cosim.record.reader import Run

SCENE_FILE = "scene.json"


def read_scene(folder: Path) -> dict[str, Any] | None:
    """The scene that a run left in its folder, if it did."""
    try:
        return json.loads((folder / SCENE_FILE).read_text(encoding="utf-8"))
    except (OSError, json.JSONDecodeError):
        return None


def recorded_of(scene: Mapping[str, Any], run: Run) -> list[str]:
    """The signals that a scene names and that were recorded, once, in order."""
    return [name for name in dict.fromkeys(_texts(scene)) if name in run.signals]


def _texts(entry: Any) -> Iterator[str]:
    if isinstance(entry, str):
        yield entry
    elif isinstance(entry, Mapping):
        for value in cast("Mapping[str, Any]", entry).values():
            yield from _texts(value)
    elif isinstance(entry, list):
        for each in cast("list[Any]", entry):
            yield from _texts(each)
