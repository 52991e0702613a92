"""The bundled single-axis scenarios with gains, initial states and channels of a test's choice."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cosim.scenario import Scenario, load
from tests.support.master.lifted_model import System, centralized, distributed

STEP = (0, 0.5, 0.1)
"""A held force of 0.5 N on hand 1 from 0.1 s on."""

PLACES = {
    "hand_1": (0.01, 0.1),
    "hand_2": (-0.004, -0.2),
    "object": (0.002, 0.05),
    "object_1": (0.002, 0.05),
    "object_2": (-0.001, 0.02),
}
"""Initial position (m) and velocity (m/s)."""

Gains = Mapping[str, float]

GAINS: dict[str, dict[str, Gains]] = {
    "centralized": {
        "soft": {"k_1": 800 / 3, "k_2": 20.0},
        "stiff": {"k_1": 1000.0, "k_2": 4000.0},
    },
    "distributed": {
        "soft": {"k_own": 2000.0, "k_other": 500.0, "k_o": 300.0},
        "stiff": {"k_own": 2000.0, "k_other": 6000.0, "k_o": 3000.0},
    },
}
_COUPLERS = {
    "centralized": {"coupler_1": "k_1", "coupler_2": "k_2"},
    "distributed": {
        "coupler_11": "k_own",
        "coupler_22": "k_own",
        "coupler_12": "k_other",
        "coupler_21": "k_other",
        "coupler_o1": "k_o",
        "coupler_o2": "k_o",
    },
}
ARCHITECTURES = tuple(GAINS)
BODIES = {
    "centralized": ("hand_1", "object", "hand_2"),
    "distributed": ("hand_1", "object_1", "object_2", "hand_2"),
}
"""In the order of the lifted model's masses."""


def overlay(name: str, gains: Gains, channel: Mapping[str, Any], flavour: str) -> dict[str, Any]:
    """What a test changes in a bundled scenario."""
    components: dict[str, Any] = {
        "step_1": {
            "flavour": flavour,
            "parameters": {"mode": "step", "amplitude": STEP[1], "start_time": STEP[2]},
        }
    }
    for body in BODIES[name]:
        position, velocity = PLACES[body]
        initial = {"initial_position": position, "initial_velocity": velocity}
        components[body] = {"flavour": flavour, "parameters": initial}
    for coupler, gain in _COUPLERS[name].items():
        parameters = {"stiffness": gains[gain], "damping": 10.0}
        components[coupler] = {"flavour": flavour, "parameters": parameters}
    return {"components": components, "channels": {"lan": dict(channel)}}


def single_axis(
    folder: Path,
    name: str,
    gains: Gains,
    channel: Mapping[str, Any],
    *,
    flavour: str = "fmi3",
    more: Mapping[str, Any] | None = None,
) -> Scenario:
    """``scenarios/single_axis_<name>.yaml`` with an overlay; ``more`` goes on top of it."""
    path = folder / "overlay.yaml"
    path.write_text(json.dumps(overlay(name, gains, channel, flavour)))
    overlays = [path]
    if more is not None:
        overlays.append(folder / "more.yaml")
        overlays[1].write_text(json.dumps(more))
    return load(f"single_axis_{name}", overlays)


def lifted(name: str, gains: Gains) -> System:
    """The independent model of the same system."""
    if name == "centralized":
        return centralized(m_h=0.1, m_o=0.4, **gains, b=10.0)
    return distributed(m_h=0.1, m_o=0.4, **gains, b=10.0, b_o=10.0)
