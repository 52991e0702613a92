"""One picture of a run: its scene in the middle of its time."""

from __future__ import annotations

from pathlib import Path

from cosim.record.reader import open_run
from cosim.record.scene import read_scene
from cosim.render.picture import Painter
from cosim.render.poses import read_poses

SIZE = (480, 360)
FRAMES = 60
"""Moments that the view has to hold, so that all pictures of a run have one scale."""


def draw_still(folder: Path, out: Path) -> bool:
    """Draw the scene of a run folder halfway through; whether there is anything to draw.

    Raises:
        InputError: there is no run in the folder.
        OSError: ``out`` cannot be written.
    """
    with open_run(folder) as run:
        scene = read_scene(run.folder)
        if scene is None or run.ticks == 0:
            return False
        ticks = [run.ticks * number // FRAMES for number in range(FRAMES)]
        poses = read_poses(run, scene, ticks)
    Painter(scene, poses, SIZE, scheme="light", title="").frame(FRAMES // 2).save(out, quality=85)
    return True
