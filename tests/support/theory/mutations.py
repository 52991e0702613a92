"""Scenarios changed at random: walls, delays, rates, order, prediction and the like."""

from __future__ import annotations

import numpy as np

from cosim.scenario.load import read

NAMES = ("single_user", "single_axis_centralized", "single_axis_distributed")
BODIES = {
    "single_user": ("hand_1", "object"),
    "single_axis_centralized": ("hand_1", "object", "hand_2"),
    "single_axis_distributed": ("hand_1", "object_1", "object_2", "hand_2"),
}
COUPLER = {
    "single_user": "coupler_1",
    "single_axis_centralized": "coupler_1",
    "single_axis_distributed": "coupler_11",
}


def mutations(generator: np.random.Generator, name: str) -> list[str]:
    """One to three changes, of those that the closed forms do not or did not know."""
    body, coupler = BODIES[name][1], COUPLER[name]
    wires = read(name).built().connections
    inner = [n for n, wire in enumerate(wires) if wire.via is None and wire.source.path != "value"]

    def wire(more: str) -> str:
        number = int(generator.choice(inner))
        return f"connections.{number}={wires[number].source} -> {wires[number].target} {more}"

    choices = [
        lambda: f"components.{body}.parameters.wall_stiffness={10 ** generator.uniform(2, 6)}",
        lambda: f"components.{body}.parameters.mass={generator.uniform(0.1, 2)}",
        lambda: f"components.{coupler}.parameters.stiffness={10 ** generator.uniform(1, 4)}",
        lambda: f"components.{coupler}.parameters.damping={generator.uniform(1, 15)}",
        lambda: (
            f"components.{coupler}.parameters.computation_delay_ticks={generator.integers(1, 4)}"
        ),
        lambda: wire(f"delay {generator.integers(1, 5)} ticks"),
        lambda: wire("at 512 Hz"),
        lambda: wire("at 64 Hz"),
        lambda: "base_rate=2048 Hz",
        lambda: f"components.{body}.rate=512 Hz",
        lambda: f"components.{coupler}.rate=512 Hz",
    ]
    if name != "single_user":
        choices += [
            lambda: "rates.network=64 Hz",
            lambda: "rates.network=256 Hz",
            lambda: f"channels.lan.round_trip_delay={generator.integers(0, 6)}",
            lambda: (
                "channels.lan={between: [station_1, station_2], rate: network, delay: "
                f"{{forward: {generator.integers(0, 21)} ticks, backward: 3 ticks}}}}"
            ),
        ]
    count = int(generator.integers(1, 4))
    picked = generator.choice(len(choices), size=count, replace=False)
    return [choices[int(number)]() for number in picked]


PLANAR = {
    "two_users_box": (("vr_a", "vr_b"), ("a1", "a2", "b1", "b2")),
    "two_users_box_centralized": (("server", "client"), ("a1", "a2", "b1", "b2")),
}


def planar_mutations(generator: np.random.Generator, name: str) -> list[str]:
    """One to three changes of a planar scenario; some of them have no theory of a run."""
    parts, fingers = PLANAR[name]
    is_server = name.endswith("centralized")
    worlds = parts[:1] if is_server else parts
    wires = read(name).built().connections
    inner = [n for n, wire in enumerate(wires) if wire.via is None]

    def each(owners: tuple[str, ...], text: str) -> list[str]:
        return [f"components.{owner}.{text}" for owner in owners]

    def gain(key: str, low: float, high: float) -> list[str]:
        return each(worlds, f"parameters.{key}={generator.uniform(low, high)}")

    def finger(text: str) -> list[str]:
        return [f"components.finger_{generator.choice(fingers)}.{text}"]

    def wire(more: str) -> list[str]:
        number = int(generator.choice(inner))
        return [f"connections.{number}={wires[number].source} -> {wires[number].target} {more}"]

    ends = "[station_b, station_a]" if is_server else "[station_a, station_b]"

    def delay() -> list[str]:
        there, back = (int(n) for n in generator.integers(0, 18, 2))
        way = f"{{forward: {there} ticks, backward: {back} ticks}}"
        return [f"channels.lan={{between: {ends}, rate: network, delay: {way}}}"]

    choices = [
        lambda: gain("local_normal_stiffness", 300, 1200),
        lambda: gain("remote_normal_stiffness", 60, 250),
        lambda: gain("local_tangential_damping", 3, 12),
        lambda: gain("mass", 0.2, 0.8),
        lambda: gain("static_friction", 0.5, 0.9),
        lambda: finger(f"parameters.finger_mass={generator.uniform(0.05, 0.2)}"),
        lambda: finger(f"parameters.computation_delay_ticks={generator.integers(1, 3)}"),
        lambda: finger("parameters.substeps=1"),
        lambda: finger("feedthrough=false"),
        lambda: gain("finger_1.max_force", 1.2, 4),
        lambda: wire(f"delay {generator.integers(1, 3)} ticks"),
        lambda: wire("at 512 Hz"),
        lambda: wire("at 64 Hz"),
        lambda: ["rates.network=64 Hz"],
        lambda: ["rates.network=256 Hz"],
        lambda: ["base_rate=2048 Hz"],
        lambda: (
            each(parts, "parameters.velocity_estimator=finite_difference")
            + each(parts, f"parameters.velocity_window={generator.integers(1, 9)}")
        ),
        delay,
        lambda: [f"channels.lan.round_trip_delay={generator.integers(0, 4)}"],
        lambda: each(worlds, "parameters.predictor=linear"),
        lambda: each(parts, "parameters.passivity=time_domain"),
        lambda: each(parts, "parameters.deadband=0.1"),
        lambda: ["channels.lan.loss=0.1"],
        lambda: ["channels.lan.jitter=1"],
        lambda: each(worlds, "parameters.wall_1={enabled: true, point_y: -0.0499}"),
    ]
    if is_server:
        choices.append(lambda: each(parts, "parameters.force_channel=wave"))
    else:
        choices.append(lambda: each(worlds, "parameters.environment=mass_spring"))
        choices.append(lambda: gain("coupling_stiffness", 20, 150))
        choices.append(lambda: gain("compensation.x", -1.5, 1.0))
    count = int(generator.integers(1, 4))
    picked = generator.choice(len(choices), size=count, replace=False)
    return [text for number in picked for text in choices[int(number)]()]
