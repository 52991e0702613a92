"""What the theory of a run cannot answer for, refused by name."""

from __future__ import annotations

from cosim.analysis.chance.delays import HARMLESS, link_delays
from cosim.analysis.parameter import parameter
from cosim.analysis.wires import turned_parameters
from cosim.base.errors import InputError
from cosim.scenario import Kind, Scenario, ScenarioComponent

_WORD = {
    Kind.PYTHON: "is written in Python and does not declare its state",
    Kind.DEVICE: "is a device, whose state nobody knows",
    Kind.PLAYBACK: "is played back, so that nothing acts on it",
    Kind.TABLE: "is read from a table, so that nothing acts on it",
}


def refuse_what_has_no_theory(scenario: Scenario) -> None:
    """Refuse parts whose state cannot be moved, those that switch, and what is turned on the way.

    So are channels whose packets follow something recorded.

    Raises:
        InputError: by name and place.
    """
    refuse_turned(scenario)
    for link in chances(scenario):
        link_delays(scenario, link)
    read = {link.source.component for link in scenario.connections}
    for name, part in scenario.components.items():
        place = scenario.locate(("components", name))
        if part.kind in _WORD and name in read:
            raise InputError(
                f"{name} {_WORD[part.kind]}, and other parts depend on it: the theory of a run "
                "needs bundled models in the loop.",
                place,
            )
        if part.is_bundled:
            _refuse_deadband(scenario, part)
            _refuse_passivity(scenario, part)
            _refuse_intent(scenario, part)


def refuse_turned(scenario: Scenario) -> None:
    """Refuse what is turned on the way, by events and by connections: the theory is of one plan.

    Raises:
        InputError: by name and place.
    """
    for event in scenario.events:
        raise InputError(
            f"{event.target} is turned at tick {event.tick}, and the theory of a run is of one "
            "plan: lay a file with 'events: ~' over it, and set what is in force at the moment "
            "that you ask for.",
            scenario.locate(event.written),
        )
    for number, link in turned_parameters(scenario):
        what = "a channel" if link.target.component in scenario.channels else "a parameter"
        raise InputError(
            f"{link} turns {what}, and the theory of a run is of one plan: leave the connection "
            "out, and set what is in force at the moment that you ask for.",
            scenario.locate(("connections", number)),
        )


def _refuse_deadband(scenario: Scenario, part: ScenarioComponent) -> None:
    if "deadband" in part.parameters and parameter(part, "deadband") > 0.0:
        raise InputError(
            f"{part.name} has a deadband: within it nothing is sent, so that the loop has no "
            f"derivative. Ask without it: --set components.{part.name}.parameters.deadband=0.",
            scenario.locate(("components", part.name, "parameters", "deadband")),
        )


def _refuse_passivity(scenario: Scenario, part: ScenarioComponent) -> None:
    if part.parameters.get("passivity") in {"time_domain", 1}:
        raise InputError(
            f"{part.name} has a passivity controller, which acts where energy has run out: the "
            "loop is one of two, and which one depends on its past. Ask without it: "
            f"--set components.{part.name}.parameters.passivity=none.",
            scenario.locate(("components", part.name, "parameters", "passivity")),
        )


def _refuse_intent(scenario: Scenario, part: ScenarioComponent) -> None:
    if part.parameters.get("predictor") in {"intent", 2}:
        raise InputError(
            f"{part.name} guesses what hands intend: how much it believes of a motion depends on "
            "how large that is, so that no map holds for small and large ones. Ask with "
            f"--set components.{part.name}.parameters.predictor=linear, or hold_last.",
            scenario.locate(("components", part.name, "parameters", "predictor")),
        )


def chances(scenario: Scenario) -> dict[str, tuple[str, ...]]:
    """What the channels that are in use do by chance, as ``channel.direction``."""
    used = {link.via for link in scenario.connections if link.via is not None}
    found: dict[str, tuple[str, ...]] = {}
    for name in sorted(used):
        channel = scenario.channels[name]
        for way, direction in (("forward", channel.forward), ("backward", channel.backward)):
            if direction.impairments:
                found[f"{name}.{way}"] = tuple(direction.impairments)
    return found


def refuse_chance(scenario: Scenario, what: str) -> None:
    """Refuse channels whose packets are lost or late by chance, for what is a property of one map.

    Args:
        scenario: what runs.
        what: what is asked for, to be said.

    Raises:
        InputError: by name and place.
    """
    for link, effects in chances(scenario).items():
        name = link.rsplit(".", 1)[0]
        others = [effect for effect in effects if effect not in HARMLESS]
        if others:
            raise InputError(
                f"{link} has {' and '.join(others)}, so that every period has a map of its own, "
                f"and {what} of one: ask without, --set channels.{name}.{others[0]}=~, or for the "
                "mean-square radius with 'cohaptic theory radius'.",
                scenario.locate(("channels", name)),
            )
