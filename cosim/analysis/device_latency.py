"""What the latency of real devices makes of a scenario's couplers: stable at n ticks, or not.

A device shows the effect of a torque so many ticks later than the pantograph FMU does, which is a
computation delay in the loop of chapter 5: z^-1 for one tick. At b = 10 N.s/m and 1024 Hz one tick
takes the largest stiffness of a single user from 20480 to 6435 N/m.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction

from cosim.analysis.grasp import WORKSTATION
from cosim.analysis.left_out import SERVER
from cosim.analysis.loop import read_loop
from cosim.analysis.parameter import parameter
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import Timing
from cosim.theory.stability.spectral_radius import stability, stable_intervals

SOFTEST, STIFFEST = 1.0, 1e6
"""Where the largest stiffness is searched for (N/m)."""
_LOCAL = ("normal", "tangential")


def latency_warnings(scenario: Scenario, latency: Mapping[str, int]) -> list[str]:
    """A sentence for each coupler, and for the whole loop, that its devices' latency unsettles.

    ``latency`` gives each device component's, in its own ticks. What the theory cannot read is not
    judged.
    """
    ticks = max(latency.values(), default=0)
    if ticks == 0:
        return []
    delayed: dict[tuple[str, int], list[str]] = {}
    for name, late in latency.items():
        for part in _workstations(scenario, name) if late else []:
            delayed.setdefault((part, late), []).append(name)
    found: list[str] = []
    for (part, late), names in delayed.items():
        found += _local(scenario, scenario.components[part], " and ".join(names), late)
    return found + _whole(scenario, ticks)


def _workstations(scenario: Scenario, device: str) -> list[str]:
    """The workstations that compute this device's torque."""
    sources = {
        connection.source.component
        for connection in scenario.connections
        if connection.target.component == device
    }
    parts = (scenario.components.get(name) for name in sorted(sources))
    return [p.name for p in parts if p and p.is_bundled and p.source in {WORKSTATION, SERVER}]


def _local(scenario: Scenario, part: ScenarioComponent, devices: str, late: int) -> list[str]:
    """The user's own contact, which is the single-user loop of chapter 3."""
    found: list[str] = []
    period = part.period / scenario.base_rate
    for axis in _LOCAL:
        stiffness = parameter(part, f"local_{axis}_stiffness")
        loop = Parameters(
            "single",
            {
                "m_h": parameter(part, "hand_mass"),
                "b_h": 0.0,
                "m_o": parameter(part, "mass"),
                "b_c": 0.0,
                "k": stiffness,
                "b": parameter(part, f"local_{axis}_damping"),
                "k_w": 0.0,
                "b_w": 0.0,
            },
            {},
            users=1,
        )
        timing = Timing(control_period=period, ratio=Fraction(1), computation_delay=late)
        if stability(loop.model(), timing).stable:
            continue
        name = f"{part.name}.local_{axis}_stiffness"
        found.append(
            f"{name} = {stiffness:g} N/m is unstable at the {_ticks(late)} of latency of "
            f"{devices}: at most {_most(loop, timing):.0f} N/m at b = {loop['b']:g} N.s/m "
            f"(without latency {_most(loop, replace(timing, computation_delay=0)):.0f})"
        )
    return found


def _most(loop: Parameters, timing: Timing) -> float:
    """Upper end of the first stable interval of k (N/m); 0 where there is none."""

    def radius(stiffness: float) -> float:
        return stability(loop.replaced({"k": stiffness}).model(), timing).spectral_radius

    intervals = stable_intervals(radius, SOFTEST, STIFFEST, points=120)
    return intervals[0][1] if intervals else 0.0


def _whole(scenario: Scenario, ticks: int) -> list[str]:
    """Everyone holding on, all couplers delayed."""
    try:
        loop = read_loop(scenario)
    except InputError:
        return []
    parameters = Parameters(loop.architecture, loop.values, {}, users=loop.users)
    late = replace(loop.timing, computation_delay=max(ticks, loop.timing.computation_delay))
    found = stability(parameters.model(), late)
    if found.stable or not stability(parameters.model(), loop.timing).stable:
        return []
    sentence = (
        f"the loop of all {loop.users} users is stable in simulation and unstable with "
        f"{_ticks(ticks)} of device latency (spectral radius {found.spectral_radius:.4f}): soften "
        "its couplers, or see 'cohaptic theory boundary'"
    )
    return [sentence]


def _ticks(count: int) -> str:
    return "1 tick" if count == 1 else f"{count} ticks"
