"""The stiffest wall that a scenario's own device renders, asked of the kernel.

The device, its encoders, DAC, amplifier and friction, the workstation's velocity estimator and what
else it does are those of the scenario; the wall is a face of a box that nothing moves. A hand that
presses with a constant force and holds on to its place along the wall lets go from inside it, and a
wall counts as rendered while the tip comes to rest there.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.analysis.answers.device_of_wall import ScenarioDevice
from cosim.analysis.monodromy.idealised import idealised
from cosim.analysis.monodromy.run_map import RunMap
from cosim.analysis.parameter import parameter
from cosim.base.quantities.quantity import quantity
from cosim.base.recording import MemorySink
from cosim.master.assembly.variation import with_values
from cosim.master.run.simulation import assemble
from cosim.scenario import Scenario, ScenarioComponent
from cosim.scenario.load import Written
from cosim.theory.robust.z_width import LOOKED, RenderedWall, comes_to_rest, stiffest

Real = NDArray[np.float64]

DEVICE, STATION, HAND = "device", "wall", "hand"
PRESSED = 1.0
"""N, with which the hand presses."""
INSIDE = 2e-4
"""m inside the wall, where the hand lets go."""
SIDE = 0.2
"""m: of the box whose face is the wall."""
ALONG = (100.0, 3.0)
"""N/m and N·s/m, a relaxed hand's, with which the hand holds on to its place along the wall."""
UNMOVED = 1e12
"""kg, kg·m²: of a box that 1 N moves by a picometre in a second."""
NUDGE = 1e-4
"""N, by which mass and damping of the device are measured."""


class WallOfDevice:
    """The walls of a scenario's device; close it when done.

    Args:
        written: the scenario.
        chosen: whose wall.

    Attributes:
        facts: what rule and eigenvalues are taken of: mass and damping at the tip along the axis,
            the period, the ticks that a torque waits, and a count at the tip.
    """

    def __init__(self, written: Written, chosen: ScenarioDevice) -> None:
        self._chosen = chosen
        scenario = written.built()
        self._period = float(Fraction(chosen.station.period) / scenario.base_rate)
        self._written = written.changed(_wall_scenario(scenario, chosen))
        self._simulation = assemble(self._written.built())
        self._sink = MemorySink()
        self._fresh = True
        self.facts = self._measured()

    def as_built(self, damping: Sequence[float], levels: int = 24) -> Real:
        """The largest stiffness at which the tip comes to rest, N/m, shape of ``damping``."""
        return stiffest(self.facts, damping, self.rests, levels)

    def close(self) -> None:
        """Free the FMUs."""
        self._simulation.close()

    def __enter__(self) -> WallOfDevice:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def rests(self, stiffness: float, damping: float) -> bool:
        """Whether the tip comes to rest in a wall (N/m, N·s/m)."""
        wall = f"components.{STATION}.parameters"
        sets = [
            f"{wall}.local_normal_stiffness={float(stiffness)!r}",
            f"{wall}.local_normal_damping={float(damping)!r}",
        ]
        assembly = with_values(self._simulation.assembly, self._written.changed(sets).built())
        assert assembly is not None, "stiffness and damping change no plan"
        self._simulation.renew(assembly)
        self._simulation.run(self._sink, keep_fmus=True)
        seen = np.asarray(
            self._sink.signal(f"{DEVICE}.tip_position[{self._chosen.axis + 1}]"), dtype=np.float64
        )
        return bool(comes_to_rest(seen[:, None], self._period, self.facts.count)[0])

    def _measured(self) -> RenderedWall:
        """The device as its own model has it: a nudge of the free tip, and the tick after it."""
        ideal = idealised(self._written.changed(_far_away()), self._written.built()).written
        with assemble(ideal.built()) as free:
            free.start(free.scenario.ticks)
            free.advance(64)
            run = RunMap(free)
            axis = self._chosen.axis + 1
            speeds = [self._nudged(run, axis, sign) for sign in (1.0, -1.0)]
            first, second = ((speeds[0][n] - speeds[1][n]) / 2.0 for n in range(2))
            mass = NUDGE * self._period / first
            damping = max(mass * (1.0 - second / first) / self._period, 0.0)
            count = self._count(run, axis)
        late = int(parameter(self._chosen.device, "computation_delay_ticks"))
        return RenderedWall(mass, damping, self._period, late, count)

    def _nudged(self, run: RunMap, axis: int, sign: float) -> tuple[float, float]:
        """The speed of the tip after a tick with a nudge of the hand, and a tick later."""
        run.put(run.start)
        was = run.output(HAND, f"force_amplitude[{axis}]")
        run.fmus[HAND].overwrite({f"force_amplitude[{axis}]": was + sign * NUDGE})
        run.simulation.advance(run.tick + 1)
        first = run.output(DEVICE, f"tip_velocity[{axis}]")
        run.fmus[HAND].overwrite({f"force_amplitude[{axis}]": was})
        run.simulation.advance(run.tick + 2)
        return first, run.output(DEVICE, f"tip_velocity[{axis}]")

    def _count(self, run: RunMap, axis: int) -> float:
        """How far the tip goes along the axis with one encoder count of both joints."""
        counts = _encoder_counts(self._chosen.device)
        if counts == 0:
            return 0.0
        moved = 0.0
        for joint in range(2):
            place = next(
                number
                for number, one in enumerate(run.coordinates)
                if one.owner == DEVICE and one.name == f"motion.angle[{joint}]"
            )
            ends: list[float] = []
            for sign in (1.0, -1.0):
                state = run.start.copy()
                state[place] += sign * np.pi / counts
                run.put(state)
                ends.append(run.output(DEVICE, f"tip_position[{axis}]"))
            moved += abs(ends[0] - ends[1])
        return moved


def _encoder_counts(part: ScenarioComponent) -> int:
    from fmus.shared.mechanism.device import presets

    given = int(parameter(part, "encoder_counts"))
    if given >= 0:
        return given
    haply = part.parameters.get("device", "quanser") in {"haply", 1}
    return int(presets("GEOMETRY")["encoder_counts"][int(haply)])


def _far_away() -> list[str]:
    return [f"components.{STATION}.parameters.initial_box_pose.{axis}=10.0" for axis in "xy"]


def _wall_scenario(scenario: Scenario, chosen: ScenarioDevice) -> list[str]:
    """The overrides that leave the device, its workstation, a hand and a box that nothing moves."""
    rate = f"{scenario.base_rate / chosen.station.period} Hz"
    place = _start(chosen.device)
    axis, other = chosen.axis, 1 - chosen.axis
    corner = list(place)
    corner[axis] += SIDE / 2 - INSIDE
    alike = {"station": chosen.station.station, "rate": rate}
    station = {
        **_as_finger_1(chosen.station, chosen.finger),
        "fingers": 1,
        "peers": 0,
        "environment": "box",
        "mass": UNMOVED,
        "inertia": UNMOVED,
        "side": SIDE,
        "gravity": 0.0,
        "initial_box_pose": {"x": corner[0], "y": corner[1], "theta": 0.0},
        "local_normal_stiffness": 100.0,
        "local_normal_damping": 1.0,
        "local_tangential_stiffness": 0.0,
        "local_tangential_damping": 0.0,
        "static_friction": 0.0,
        "kinetic_friction": 0.0,
    }
    hand = {
        "impedance": "custom",
        "stiffness": [ALONG[0] if n == other else 0.0 for n in range(2)],
        "damping": [ALONG[1] if n == other else 0.0 for n in range(2)],
        "initial_position": place,
        "force_mode": ["constant" if n == axis else "none" for n in range(2)],
        "force_amplitude": [PRESSED if n == axis else 0.0 for n in range(2)],
    }
    device = _nested(chosen.device)
    components = {
        DEVICE: {"fmu": "pantograph", **alike, "parameters": device},
        STATION: {"fmu": "distributed_workstation", **alike, "parameters": station},
        HAND: {"fmu": "operator", **alike, "parameters": hand},
    }
    connections = [
        f"{HAND}.force -> {DEVICE}.hand_force",
        f"{DEVICE}.tip_position -> {HAND}.position",
        f"{DEVICE}.tip_velocity -> {HAND}.velocity",
        f"{DEVICE}.device -> {STATION}.finger_1",
        f"{STATION}.finger_1 -> {DEVICE}.device",
    ]
    replaced = ("components", "connections", "channels", "record", "expect", "events", "knobs")
    return [
        *(f"{key}=~" for key in replaced),
        f"components={json.dumps(components)}",
        f"connections={json.dumps(connections)}",
        f"record={json.dumps([f'{DEVICE}.tip_position'])}",
        f"duration={2 * LOOKED[1] - LOOKED[0]} s",
    ]


def _start(device: ScenarioComponent) -> list[float]:
    given: Any = device.parameters.get("initial_tip_position")
    if given is None:
        return [parameter(device, f"initial_tip_position[{axis}]") for axis in (1, 2)]
    return [float(quantity(one, "m")) for one in given]


_KEPT = ("velocity_", "passivity", "finger_1.", "max_force", "moment_cancellation", "hand_mass")
"""What of a workstation has a part in the wall of one finger."""


def _as_finger_1(station: ScenarioComponent, finger: int) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for path, value in _nested(station).items():
        key = "finger_1" if path == f"finger_{finger}" else path
        if path.startswith("finger_") and key != "finger_1":
            continue
        if f"{key}.".startswith(_KEPT) or key.startswith(_KEPT):
            found[key] = value
    return found


def _nested(part: ScenarioComponent) -> dict[str, Any]:
    """A component's parameters as they are written: groups as mappings."""
    found: dict[str, Any] = {}
    for path, value in part.parameters.items():
        *groups, last = path.split(".")
        place = found
        for group in groups:
            place = place.setdefault(group, {})
        place[last] = list(value) if isinstance(value, tuple) else value
    return found
