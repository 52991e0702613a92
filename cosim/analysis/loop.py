"""Any scenario that the theory can analyse, as a loop of chapters 3 to 6.

Single-axis scenarios are read as they are. Of the planar ones the normal axis is read, with one
finger a user, everyone holding the box: the model that chapter 8 compares its experiments with.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from cosim.analysis.chance.delays import HARMLESS
from cosim.analysis.grasp import WORKSTATION, find_grasp
from cosim.analysis.left_out import (
    CLIENT,
    SERVER,
    refuse_recorded_fates,
    refuse_what_chapters_leave_out,
)
from cosim.analysis.monodromy.refusal import chances
from cosim.analysis.parameter import parameter, refuse_unknown_parameters
from cosim.analysis.single_axis import ScenarioLoop, read_single_axis
from cosim.analysis.single_axis_parts import WITHOUT_CHANCE
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent
from cosim.theory.models.timing import PathDelay, Timing

ROUNDED = "is taken as"
"""In the note of a delay that is longer here than in the run."""
_PLANAR = (
    "One finger a user on the box's normal axis, everyone holding on; friction, quantisation, "
    "velocity estimation and what hands hold on with are left out."
)


def read_loop(scenario: Scenario) -> ScenarioLoop:
    """The loop of a scenario.

    Raises:
        InputError: where the scenario has no loop that chapters 3 to 6 know, or has more than it.
    """
    for part in scenario.components.values():
        if part.is_bundled:
            refuse_unknown_parameters(scenario, part)
    refuse_what_chapters_leave_out(scenario)
    refuse_recorded_fates(scenario)
    sources = {part.source for part in scenario.components.values() if part.is_bundled}
    if WORKSTATION in sources:
        return _read_workstations(scenario)
    if SERVER in sources:
        return _read_server(scenario)
    return read_single_axis(scenario)


def _read_workstations(scenario: Scenario) -> ScenarioLoop:
    grasp = find_grasp(scenario)
    _refuse_untold_compensation(scenario, grasp.workstations)
    model = grasp.model("normal")
    users = range(1, model.users + 1)
    values: dict[str, float] = {"k_w": 0.0, "b_w": 0.0}
    for m in users:
        part = grasp.workstations[m - 1]
        values[f"m_h{m}"], values[f"b_h{m}"] = float(model.hand_mass[m - 1]), 0.0
        values[f"m_o{m}"] = float(model.object_mass[m - 1])
        values[f"b_c{m}"] = parameter(part, "compensation.x")
        values[f"k_{m}{m}"] = float(model.local_stiffness[m - 1])
        values[f"b_{m}{m}"] = float(model.local_damping[m - 1])
        for r in users:
            if r == m:
                continue
            values[f"k_{m}{r}"] = float(model.remote_stiffness[m - 1, r - 1])
            values[f"b_{m}{r}"] = float(model.remote_damping[m - 1, r - 1])
            values[f"k_o{m}"] = float(model.object_stiffness[m - 1, r - 1])
            values[f"b_o{m}"] = float(model.object_damping[m - 1, r - 1])
    return ScenarioLoop("distributed", model.users, values, grasp.timing, _notes(scenario))


def _read_server(scenario: Scenario) -> ScenarioLoop:
    parts = [part for part in scenario.components.values() if part.is_bundled]
    servers = [part for part in parts if part.source == SERVER]
    clients = [part for part in parts if part.source == CLIENT]
    if len(servers) != 1 or not clients:
        raise InputError(
            "A centralized scenario has one central_server and at least one remote_client.",
            scenario.locate(("components",)),
        )
    server = servers[0]
    values: dict[str, float] = {"k_w": 0.0, "b_w": 0.0, "m_o": parameter(server, "mass")}
    values["b_c"] = parameter(server, "compensation.x")
    for m in range(1, len(clients) + 2):
        side = "local" if m == 1 else "remote"
        # A client does not know its hand's mass; the server's hands stand for all.
        values[f"m_h{m}"], values[f"b_h{m}"] = parameter(server, "hand_mass"), 0.0
        values[f"k_{m}"] = parameter(server, f"{side}_normal_stiffness")
        values[f"b_{m}"] = parameter(server, f"{side}_normal_damping")
    timing = _server_timing(scenario, server, clients)
    return ScenarioLoop("centralized", len(clients) + 1, values, timing, _notes(scenario))


def _notes(scenario: Scenario) -> tuple[str, ...]:
    """What is left out, and which delays are longer here than in the run."""
    notes = {_PLANAR: None}
    if any(effect not in HARMLESS for effects in chances(scenario).values() for effect in effects):
        notes[WITHOUT_CHANCE] = None
    for name in dict.fromkeys(link.via for link in scenario.connections if link.via is not None):
        channel = scenario.channels[name]
        for way in (channel.forward, channel.backward):
            samples = -(-way.delay.ticks // channel.period)
            if samples * channel.period != way.delay.ticks:
                notes[f"A delay of {way.delay.ticks} ticks {ROUNDED} {samples} samples."] = None
    return tuple(notes)


def _refuse_untold_compensation(
    scenario: Scenario, workstations: Iterable[ScenarioComponent]
) -> None:
    """A compensation that is still a word has no number.

    Raises:
        InputError: with its place.
    """
    for part in workstations:
        if isinstance(part.parameters.get("compensation"), str):
            raise InputError(
                f"{part.name} has a compensation that the theory has yet to compute; load the "
                "scenario with its numbers (cohaptic.load).",
                scenario.locate(("components", part.name, "parameters", "compensation")),
            )


def _server_timing(
    scenario: Scenario, server: ScenarioComponent, clients: list[ScenarioComponent]
) -> Timing:
    stations = {part.station for part in clients}
    delays: dict[bool, set[int]] = {True: set(), False: set()}
    periods: set[int] = set()
    for link in scenario.connections:
        source = scenario.components.get(link.source.component)
        target = scenario.components.get(link.target.component)
        if link.via is None or source is None or target is None:
            continue
        up = source.station in stations and target.name == server.name
        if not up and not (source.name == server.name and target.station in stations):
            continue
        channel = scenario.channels[link.via]
        ticks = channel.direction(source.station, target.station).delay.ticks
        periods.add(channel.period)
        delays[up].add(-(-ticks // channel.period))
    if len(periods) != 1 or any(len(way) != 1 for way in delays.values()):
        raise InputError(
            "The theory takes one network rate, and one delay up and one down, for all clients.",
            scenario.locate(("channels",)),
        )
    return Timing(
        control_period=Fraction(server.period) / scenario.base_rate,
        ratio=Fraction(periods.pop(), server.period),
        delay=PathDelay(forward=delays[True].pop(), backward=delays[False].pop()),
    )
