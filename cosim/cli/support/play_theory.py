"""What chapters 3 to 6 say at the knobs of a played scenario: spectral radii on a grid of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

from cosim.base.errors import CohapticError

if TYPE_CHECKING:
    from cosim.live.knobs import PageKnob
    from cosim.scenario import Scenario

PLACES = {
    "coupling_stiffness": ("k_o1", "k_o2"),
    "remote_normal_stiffness": ("k_2",),
    "compensation": ("b_c", "b_c1", "b_c2"),
}
"""The loop's parameters that a knob turns."""
LEVELS = {"coupling_stiffness": 9, "remote_normal_stiffness": 9, "compensation": 3}
DELAY = "round_trip_delay"


def radii(scenario: Scenario, knobs: Sequence[PageKnob]) -> dict[str, Any] | None:
    """Spectral radius over one network period at every point of a grid of the knobs.

    ``axes`` are the knobs' keys and levels, ``radii`` the values, the last axis fastest. ``None``
    where the theory has no loop of the scenario. Loss and jitter are left out.
    """
    import numpy as np

    from cosim.analysis.loop import read_loop
    from cosim.theory.models.parameters import Parameters
    from cosim.theory.models.timing import PathDelay
    from cosim.theory.stability.spectral_radius import stability

    try:
        loop = read_loop(scenario)
    except CohapticError:
        return None
    delays = [knob for knob in knobs if knob.key.endswith(DELAY)]
    turned = [knob for knob in knobs if knob.key in PLACES]
    if len(delays) != 1:
        return None
    most = int(delays[0].maximum)
    axes = [[float(n) for n in range(most + 1)]]
    axes += [np.linspace(k.minimum, k.maximum, LEVELS[k.key]).tolist() for k in turned]
    found: list[float] = []
    for delay, *levels in product(*axes):
        values = dict(loop.values)
        for knob, level in zip(turned, levels, strict=True):
            values |= {name: level for name in PLACES[knob.key] if name in values}
        model = Parameters(loop.architecture, values, {}, users=loop.users).model()
        samples = int(delay)
        path = PathDelay(forward=samples - samples // 2, backward=samples // 2)
        found.append(stability(model, replace(loop.timing, delay=path)).spectral_radius)
    keys = [delays[0].key, *(knob.key for knob in turned)]
    return {"axes": [list(axis) for axis in zip(keys, axes, strict=True)], "radii": found}
