"""What chapters 3 to 6 say at the knobs of a played scenario: spectral radii on a grid of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import TYPE_CHECKING, Any

from cosim.base.errors import CohapticError

if TYPE_CHECKING:
    from cosim.live.knobs.page_knob import PageKnob
    from cosim.scenario import Scenario

PLACES = {
    "coupling_stiffness": ("k_o1", "k_o2"),
    "remote_normal_stiffness": ("k_2",),
    "compensation": ("b_c", "b_c1", "b_c2"),
}
"""The loop's parameters that a knob turns."""
LEVELS = {"coupling_stiffness": 9, "remote_normal_stiffness": 9, "compensation": 3}
DELAY = "round_trip_delay"
MODES = 3
"""How many modes are told."""


def theory_of(scenario: Scenario, knobs: Sequence[PageKnob]) -> dict[str, Any] | None:
    """What is known of each architecture that a scenario holds, in the order of its switch.

    ``worlds`` are as :func:`radii` has them, ``switch`` the key of the knob that chooses between
    them. ``None`` where the theory has no loop of the scenario.
    """
    from cosim.analysis.worlds import alone, worlds_of
    from cosim.live.knobs.found import SWITCH

    switch = next((knob for knob in knobs if knob.key == SWITCH), None)
    names = worlds_of(scenario)
    if switch is not None:
        names = [name for name in switch.choices if name in names]
        if len(names) < len(switch.choices):
            return None
    found = [radii(alone(scenario, name), knobs) for name in names]
    worlds = [
        {"name": name, **world}
        for name, world in zip(names, found, strict=True)
        if world is not None
    ]
    if not worlds or len(worlds) < len(names):
        return None
    return {"switch": SWITCH, "worlds": worlds}


def radii(scenario: Scenario, knobs: Sequence[PageKnob]) -> dict[str, Any] | None:
    """Spectral radius over one network period at every point of a grid of the knobs.

    ``axes`` are the knobs' keys and levels, ``radii`` the values, the last axis fastest; ``modes``
    the slowest modes at each point, each its growth a second and its frequency (Hz). ``None``
    where the theory has no such loop. Loss and jitter are left out.
    """
    import numpy as np

    from cosim.analysis.loop import read_loop
    from cosim.theory.models.parameters import Parameters
    from cosim.theory.models.timing import PathDelay
    from cosim.theory.stability.spectral_radius import stability
    from cosim.theory.stability.told import slowest_motions

    try:
        loop = read_loop(scenario)
    except CohapticError:
        return None
    delays = [knob for knob in knobs if knob.key.endswith(DELAY)]
    turned = [
        knob for knob in knobs if any(name in loop.values for name in PLACES.get(knob.key, ()))
    ]
    if len(delays) != 1 or not turned or loop.timing.ratio.denominator != 1:
        return None
    most = int(delays[0].maximum)
    axes = [[float(n) for n in range(most + 1)]]
    axes += [np.linspace(k.minimum, k.maximum, LEVELS[k.key]).tolist() for k in turned]
    period = float(loop.timing.control_period * loop.timing.ratio)
    found: list[float] = []
    modes: list[list[list[float]]] = []
    for delay, *levels in product(*axes):
        values = dict(loop.values)
        for knob, level in zip(turned, levels, strict=True):
            values |= {name: level for name in PLACES[knob.key] if name in values}
        model = Parameters(loop.architecture, values, {}, users=loop.users).model()
        samples = int(delay)
        path = PathDelay(forward=samples - samples // 2, backward=samples // 2)
        known = stability(model, replace(loop.timing, delay=path))
        found.append(float(f"{known.spectral_radius:.6g}"))
        motions = slowest_motions(known.spectrum.values, period, MODES)
        modes.append([[float(f"{g:.4g}"), float(f"{f:.4g}")] for g, f in motions])
    keys = [delays[0].key, *(knob.key for knob in turned)]
    axes_told = [list(axis) for axis in zip(keys, axes, strict=True)]
    return {"axes": axes_told, "radii": found, "modes": modes}
