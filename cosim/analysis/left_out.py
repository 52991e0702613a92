"""What a planar scenario's run has and the loop of chapters 3 to 6 that is read of it has not."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.analysis.chance.delays import packet_delays
from cosim.analysis.grasp import WORKSTATION
from cosim.analysis.monodromy.refusal import chances
from cosim.analysis.parameter import is_number, parameter
from cosim.analysis.wires import INSTEAD, refuse_other_steps, refuse_scaled
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent

SERVER, CLIENT, DEVICE = "central_server", "remote_client", "pantograph"

_LEFT_OUT = {
    "predictor": "prediction",
    "force_channel": "waves",
    "passivity": "a passivity layer",
    "environment": "a soft object",
    "deadband": "a deadband",
    "computation_delay_ticks": "a computation delay",
}
_NOTHING = {0, "hold_last", "plain", "none", "box"}
_WEIGHTS = ("peer_weight", "peer_valid", "peer_age")


def refuse_what_chapters_leave_out(scenario: Scenario) -> None:
    """Refuse, by name, what the run has and the planar scenarios' loop of chapters 3 to 6 has not.

    Raises:
        InputError: with its place.
    """
    parts = [part for part in scenario.components.values() if part.is_bundled]
    loop = [part for part in parts if part.source in {WORKSTATION, SERVER, CLIENT}]
    if not {part.source for part in loop} & {WORKSTATION, SERVER}:
        return
    for part in parts:
        _refuse_options(scenario, part)
    for link in scenario.connections:
        if link.via is None and (link.delay.ticks or link.rate is not None):
            raise InputError(
                f"{link} is delayed or sampled inside a station, which the loop of chapters 3 to 6 "
                f"leaves out: {INSTEAD}.",
                scenario.locate(("connections",)),
            )
    devices = [part for part in parts if part.source == DEVICE]
    refuse_scaled(scenario, {part.name for part in (*loop, *devices)})
    refuse_other_steps(scenario, (*loop, *devices))
    for part in loop:
        _refuse_weights(scenario, part)
    _refuse_peers(scenario, loop)
    for device in devices:
        _refuse_device(scenario, device, loop)


def refuse_recorded_fates(scenario: Scenario) -> None:
    """Refuse packets that follow something recorded: the loop has fixed delays, and they none.

    Raises:
        InputError: by name and place.
    """
    for link in chances(scenario):
        name, way = link.rsplit(".", 1)
        channel = scenario.channels[name]
        direction = channel.forward if way == "forward" else channel.backward
        if packet_delays(direction, channel.period) is None:
            raise InputError(
                f"{link} has {' and '.join(sorted(direction.impairments))}, and the loop of "
                "chapters 3 to 6 a fixed delay: give the channel one in its place.",
                scenario.locate(("channels", name)),
            )


def refuse_other_peers(scenario: Scenario, workstations: Sequence[ScenarioComponent]) -> None:
    """Refuse workstations that hear of others otherwise than the loop's: not all, or not in full.

    Nor do they carry on what they heard: what is held between two packets is what the loop has.

    Raises:
        InputError: by name and place.
    """
    refuse_recorded_fates(scenario)
    for part in workstations:
        if part.parameters.get("predictor", "hold_last") not in _NOTHING:
            raise InputError(
                f"{part.name} predicts what it hears of the others, and the loop of chapters 3 to "
                "6 holds it: take predictor=hold_last, or give the compensation in numbers "
                "('cohaptic theory damping --scenario' tells that of linear prediction).",
                scenario.locate(("components", part.name, "parameters", "predictor")),
            )
        _refuse_weights(scenario, part)
    refuse_scaled(scenario, {part.name for part in workstations})
    _refuse_peers(scenario, workstations)


def _refuse_options(scenario: Scenario, part: ScenarioComponent) -> None:
    walls = [f"wall_{number}.enabled" for number in range(1, 5)]
    for name, what in (*_LEFT_OUT.items(), *((wall, "a wall") for wall in walls)):
        value = part.parameters.get(name, 0)
        if value in _NOTHING or (is_number(value) and parameter(part, name) == 0.0):
            continue
        raise InputError(
            f"{part.name} has {what}, which the loop of chapters 3 to 6 leaves out: ask for "
            "the run itself (theory radius, modes, boundary, margins, loss), or take it away.",
            scenario.locate(("components", part.name, "parameters", name)),
        )


def _refuse_weights(scenario: Scenario, part: ScenarioComponent) -> None:
    """Peers count in full in the loop."""
    for name in _WEIGHTS:
        if name in part.start:
            raise InputError(
                f"{part.name} starts with a {name} of its own, which the loop of chapters 3 to 6 "
                f"leaves out: {INSTEAD}.",
                scenario.locate(("components", part.name, "start", name)),
            )
    for number, link in enumerate(scenario.connections):
        if link.target.component == part.name and link.target.path.startswith(_WEIGHTS):
            raise InputError(
                f"{link} weighs a peer, which the loop of chapters 3 to 6 leaves out: {INSTEAD}.",
                scenario.locate(("connections", number)),
            )


def _refuse_peers(scenario: Scenario, loop: Sequence[ScenarioComponent]) -> None:
    """Everyone hears everyone else, each once and all in use."""
    workstations = [part for part in loop if part.source == WORKSTATION]
    for part in workstations:
        others = {other.name for other in workstations} - {part.name}
        _refuse_others(scenario, part, "peer_", others)
    servers = [part for part in loop if part.source == SERVER]
    clients = [part for part in loop if part.source == CLIENT]
    for server in servers:
        _refuse_others(scenario, server, "client_", {part.name for part in clients})
    for client in clients:
        heard = [
            link.source.component
            for link in scenario.connections
            if link.target.component == client.name and link.target.path.startswith("down")
        ]
        if heard != [server.name for server in servers]:
            raise InputError(
                f"{client.name} hears {_named(heard)}, and in the loop of chapters 3 to 6 it is "
                f"told its forces by the server, in one connection: {INSTEAD}.",
                scenario.locate(("components", client.name)),
            )


def _refuse_others(
    scenario: Scenario, part: ScenarioComponent, terminal: str, others: set[str]
) -> None:
    """Who is heard at ``peer_1`` and so on: ``others``, and as many as ``peers`` says."""
    heard = {
        link.target.path: link.source.component
        for link in scenario.connections
        if link.target.component == part.name
        and link.target.path.startswith(terminal)
        and link.target.path.removeprefix(terminal).split(".")[0].isdigit()
    }
    used = {f"{terminal}{number}" for number in range(1, int(parameter(part, "peers")) + 1)}
    if set(heard) != used or sorted(heard.values()) != sorted(others):
        raise InputError(
            f"{part.name} hears {_named(sorted(set(heard.values())))} at "
            f"{_named(sorted(heard))}, and has {len(used)} peers: in the loop of chapters 3 to 6 "
            f"everyone hears everyone else, each in one connection. {INSTEAD.capitalize()}.",
            scenario.locate(("components", part.name)),
        )


def _refuse_device(
    scenario: Scenario, device: ScenarioComponent, loop: Sequence[ScenarioComponent]
) -> None:
    """A device steps with what renders on it, and moves the mass that the loop has."""
    names = {part.name: part for part in loop}
    for link in scenario.connections:
        part = names.get(link.target.component)
        if part is None or link.source.component != device.name:
            continue
        if part.period != device.period:
            raise InputError(
                f"{device.name} steps {float(device.rate):g} times a second and {part.name} "
                f"{float(part.rate):g} times: the loop of chapters 3 to 6 has one control rate; "
                f"{INSTEAD}.",
                scenario.locate(("components", device.name, "rate")),
            )
        if "finger_mass" in device.parameters and "hand_mass" not in _of_hands(part, names):
            raise InputError(
                f"{device.name} has a finger_mass of its own, and the loop of chapters 3 to 6 has "
                f"the hand_mass of {part.name}, which is not given: give it, or {INSTEAD}.",
                scenario.locate(("components", device.name, "parameters", "finger_mass")),
            )


def _of_hands(part: ScenarioComponent, loop: dict[str, ScenarioComponent]) -> dict[str, object]:
    """What is given to the part whose ``hand_mass`` stands for a device's; a client has none."""
    if part.source != CLIENT:
        return dict(part.parameters)
    servers = [other for other in loop.values() if other.source == SERVER]
    return dict(servers[0].parameters) if servers else {}


def _named(names: Sequence[str]) -> str:
    return ", ".join(names) or "nobody"
