"""The names of a planar grasp's modes, by how fingers and box move in them.

*Squeeze*: a user's fingers against each other. *Carry*: together along the normals of the faces
that they touch. *Lift*: together along the faces. *Turn*: along the faces, one up and one down.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.monodromy.run_map import RunMap
from cosim.analysis.monodromy.spectrum import RunMode

_FINGERS = (0, 1)


def mode_name(run: RunMap, mode: RunMode) -> str:
    """squeeze, carry, lift or turn; empty where there is no grasp, or nobody moves."""
    amounts = {"squeeze": 0.0, "carry": 0.0, "lift": 0.0, "turn": 0.0}
    for station, face in _grasps(run).items():
        moved = [_moved(run, mode, station, finger) for finger in _FINGERS]
        normal = 0 if face in {1, 3} else 1
        along = [m[normal] for m in moved]
        across = [m[1 - normal] for m in moved]
        amounts["squeeze"] += abs(along[0] - along[1]) ** 2
        amounts["carry"] += abs(along[0] + along[1]) ** 2
        amounts["lift"] += abs(across[0] + across[1]) ** 2
        amounts["turn"] += abs(across[0] - across[1]) ** 2
    name = max(amounts, key=lambda key: amounts[key])
    return name if amounts[name] > 0.0 else ""


def _grasps(run: RunMap) -> dict[str, int]:
    """The workstations with two fingers, and the face that the first of them touches."""
    found: dict[str, int] = {}
    for name, each in run.fmus.items():
        paths = {one.path for one in each.declared.live}
        if "own.finger[1].position.x" not in paths:
            continue
        face = each.word("environment.own[0].face") or each.word("environment.own[1].face")
        found[name] = face or 1
    return found


def _moved(run: RunMap, mode: RunMode, station: str, finger: int) -> NDArray[np.complex128]:
    wanted = [f"own.finger[{finger}].position.{axis}" for axis in "xy"]
    places = {
        one.name: number for number, one in enumerate(run.coordinates) if one.owner == station
    }
    return mode.shape[[places[name] for name in wanted]]


def named(run: RunMap, modes: Sequence[RunMode]) -> list[str]:
    """The name of each mode: the grasp's, or who takes part most."""
    return [
        mode_name(run, mode) or ", ".join(list(mode.participation)[:2]) or "memory"
        for mode in modes
    ]
