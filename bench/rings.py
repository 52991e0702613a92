"""Rings and chains of light FMUs: our masses (``hand``, FMI 2.0), each of which pushes the next."""

from __future__ import annotations

import json
from pathlib import Path

from cosim.scenario import Scenario, load


def scenario(
    size: int, shape: str, ticks: int, folder: Path, *, rate: int = 1024, every: int = 1
) -> Scenario:
    """Masses in a row; in a ring the last one pushes the first.

    The even ones are stepped at ``rate`` (Hz), the odd ones at every ``every``-th of its ticks.
    """
    common = {"fmu": "hand", "flavour": "fmi2", "feedthrough": True}
    parts = {
        f"m{n}": common | {"rate": rate // every if n % 2 else rate, "parameters": {"mass": 1.0}}
        for n in range(size)
    }
    parts["m0"]["parameters"] = {"mass": 1.0, "initial_position": 0.25}
    last = size if shape == "ring" else size - 1
    joined = [
        {"from": f"m{n}.position", "to": f"m{(n + 1) % size}.force", "unit": "ignore"}
        for n in range(last)
    ]
    written = {"cohaptic": 1, "duration": f"{ticks}/{rate}", "components": parts}
    file = folder / f"{shape}.yaml"
    file.write_text(json.dumps(written | {"connections": joined, "record": ["*.position"]}))
    return load(file)
