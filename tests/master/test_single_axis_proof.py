"""The proof: co-simulated single-axis systems are the lifted multi-rate model, to 1e-9."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lifted_model import Fate, Matrix, System, centralized, distributed, simulate
from master_support import run, scenario_of

FRAMES = 128
STEP = (0, 0.5, 0.1)
"""A held force of 0.5 N on hand 1 from 0.1 s on."""
PLACES = {
    "hand_1": (0.01, 0.1),
    "hand_2": (-0.004, -0.2),
    "object": (0.002, 0.05),
    "object_1": (0.002, 0.05),
    "object_2": (-0.001, 0.02),
}
Gains = Mapping[str, float]


def body(model: str, name: str, station: str) -> dict[str, Any]:
    position, velocity = PLACES[name]
    return {
        "fmu": model,
        "station": station,
        "rate": "control",
        "parameters": {"initial_position": position, "initial_velocity": velocity},
    }


def coupler(station: str, stiffness: float, damping: float = 10.0) -> dict[str, Any]:
    return {
        "fmu": "virtual_coupler",
        "station": station,
        "rate": "control",
        "parameters": {"stiffness": stiffness, "damping": damping},
    }


def joined(coupler: str, a: str, b: str, via_a: str = "", via_b: str = "") -> list[str]:
    """A coupler reads two bodies."""
    return [
        f"{a}.position -> {coupler}.position_a{via_a}",
        f"{a}.velocity -> {coupler}.velocity_a{via_a}",
        f"{b}.position -> {coupler}.position_b{via_b}",
        f"{b}.velocity -> {coupler}.velocity_b{via_b}",
    ]


def step(station: str) -> dict[str, Any]:
    parameters = {"mode": "step", "amplitude": STEP[1], "start_time": STEP[2]}
    return {"fmu": "signal", "station": station, "rate": "control", "parameters": parameters}


def centralized_scenario(gains: Gains, channel: Mapping[str, Any]) -> dict[str, Any]:
    """Forward is from the client (user 2) to the server (user 1)."""
    lan = " via lan"
    return {
        "duration": 1,
        "rates": {"control": 1024, "network": 128},
        "components": {
            "hand_1": body("hand", "hand_1", "server"),
            "hand_2": body("hand", "hand_2", "client"),
            "object": body("object", "object", "server"),
            "coupler_1": coupler("server", gains["k_1"]),
            "coupler_2": coupler("server", gains["k_2"]),
            "step_1": step("server"),
        },
        "channels": {"lan": {"between": ["client", "server"], "rate": "network", **channel}},
        "connections": [
            "step_1.value -> hand_1.force",
            *joined("coupler_1", "hand_1", "object"),
            *joined("coupler_2", "hand_2", "object", via_a=lan),
            "coupler_1.reaction -> hand_1.coupler_force",
            "coupler_1.force -> object.force[1]",
            "coupler_2.force -> object.force[2]",
            "coupler_2.reaction -> hand_2.coupler_force via lan",
        ],
    }


def distributed_scenario(gains: Gains, channel: Mapping[str, Any]) -> dict[str, Any]:
    """Forward is from user 1 to user 2."""
    components: dict[str, Any] = {"step_1": step("station_1")}
    connections = ["step_1.value -> hand_1.force"]
    for m, r in ((1, 2), (2, 1)):
        station, lan = f"station_{m}", " via lan"
        components |= {
            f"hand_{m}": body("hand", f"hand_{m}", station),
            f"object_{m}": body("object", f"object_{m}", station),
            f"coupler_{m}{m}": coupler(station, gains["k_own"]),
            f"coupler_{m}{r}": coupler(station, gains["k_other"]),
            f"coupler_o{m}": coupler(station, gains["k_o"]),
        }
        connections += [
            *joined(f"coupler_{m}{m}", f"hand_{m}", f"object_{m}"),
            *joined(f"coupler_{m}{r}", f"hand_{r}", f"object_{m}", via_a=lan),
            *joined(f"coupler_o{m}", f"object_{r}", f"object_{m}", via_a=lan),
            f"coupler_{m}{m}.reaction -> hand_{m}.coupler_force",
            f"coupler_{m}{m}.force -> object_{m}.force[1]",
            f"coupler_{m}{r}.force -> object_{m}.force[2]",
            f"coupler_o{m}.force -> object_{m}.force[3]",
        ]
    return {
        "duration": 1,
        "rates": {"control": 1024, "network": 128},
        "components": components,
        "channels": {"lan": {"between": ["station_1", "station_2"], "rate": "network", **channel}},
        "connections": connections,
    }


def architecture(name: str, gains: Gains) -> tuple[System, list[str]]:
    if name == "centralized":
        system = centralized(m_h=0.1, m_o=0.4, **gains, b=10.0)
        return system, ["hand_1", "object", "hand_2"]
    system = distributed(m_h=0.1, m_o=0.4, **gains, b=10.0, b_o=10.0)
    return system, ["hand_1", "object_1", "object_2", "hand_2"]


SCENARIOS = {"centralized": centralized_scenario, "distributed": distributed_scenario}
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


def error_of(
    folder: Path, name: str, gains: Gains, channel: Any, fates: Any
) -> tuple[float, float]:
    """Largest difference between co-simulation and lifted model, and the largest signal."""
    system, bodies = architecture(name, gains)
    initial = [value for body in bodies for value in PLACES[body]]
    expected: Matrix = simulate(system, initial, STEP, fates, FRAMES)
    sink, _ = run(scenario_of(folder, SCENARIOS[name](gains, channel)))
    actual = np.column_stack(
        [sink.signal(f"{b}.{quantity}") for b in bodies for quantity in ("position", "velocity")]
    )
    assert actual.shape == expected.shape
    return float(np.abs(actual - expected).max()), float(np.abs(expected).max())


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("gains", ["soft", "stiff"])
@pytest.mark.parametrize("n", [0, 1, 2, 3])
def test_co_simulation_is_the_lifted_model(tmp_path: Path, name: str, gains: str, n: int) -> None:
    there, back = (n + 1) // 2, n // 2
    fates = ([there] * FRAMES, [back] * FRAMES)
    error, peak = error_of(tmp_path, name, GAINS[name][gains], {"round_trip_delay": n}, fates)
    assert error <= 1e-9 * max(1.0, peak)
    if gains == "stiff" and n >= 1:
        assert peak > 100.0, "the unstable set must really be unstable"


def lossy(seed: int, delays: Sequence[int]) -> list[Fate]:
    """One packet in five lost, the others delayed at random."""
    random = np.random.default_rng(seed)
    lost = random.random(FRAMES) < 0.2
    drawn = random.choice(delays, FRAMES)
    return [None if gone else int(delay) for gone, delay in zip(lost, drawn, strict=True)]


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("gains", ["soft", "stiff"])
@pytest.mark.parametrize("delays", [(0, 1, 2), (1, 2, 3, 5)])
def test_so_it_is_under_loss_and_jitter(
    tmp_path: Path, name: str, gains: str, delays: tuple[int, ...]
) -> None:
    fates = (lossy(1, delays), lossy(2, delays))
    written = [["lost" if fate is None else fate for fate in way] for way in fates]
    channel = {"trace": {"forward": written[0], "backward": written[1]}}
    error, peak = error_of(tmp_path, name, GAINS[name][gains], channel, fates)
    assert error <= 1e-9 * max(1.0, peak)
