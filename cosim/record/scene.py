"""What can be drawn of a run, as it lies in its folder (``cosim.scene`` describes it)."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cosim.base.drawn import signals_of
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
    return [name for name in signals_of(scene) if name in run.signals]
