"""A starter scenario: a bundled one included, and over it what was asked for."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cosim.base.errors import InputError

if TYPE_CHECKING:
    from cosim.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Ground:
    """A bundled scenario to stand on."""

    motion: str
    users: str
    architecture: str
    name: str


GROUNDS = (
    Ground("plane", "2", "distributed", "two_users_box"),
    Ground("plane", "2", "centralized", "two_users_box_centralized"),
    Ground("plane", "3", "distributed", "thesis/three_users"),
    Ground("plane", "4", "distributed", "thesis/four_users"),
    Ground("axis", "2", "distributed", "single_axis_distributed"),
    Ground("axis", "2", "centralized", "single_axis_centralized"),
    Ground("axis", "1", "", "single_user"),
)
HOLDERS = {"object", "distributed_workstation", "central_server"}
"""FMUs that have the shared object in them."""
MASS = 0.4
"""Its mass (kg) where a scenario names none."""
TRAITS = ("motion", "users", "architecture")


@dataclass(frozen=True, slots=True)
class Answers:
    """What is to be other than in the bundled scenario; ``None`` is asked for, or as there."""

    delay: int | None
    loss: float | None
    mass: float | None
    duration: str | None


def ground(given: Mapping[str, str | None], choose: Callable[[str, list[str]], str]) -> Ground:
    """The bundled scenario with these traits; of what is left open, ``choose`` says which.

    Raises:
        InputError: there is none.
    """
    left = list(GROUNDS)
    for trait, wanted in given.items():
        fitting = [each for each in left if wanted in {None, getattr(each, trait)}]
        if not fitting:
            known = sorted({getattr(each, trait) for each in left} - {""})
            others = f"; there is {' and '.join(known)}" if known else ""
            raise InputError(f"no bundled scenario has --{trait} {wanted} with the rest{others}.")
        left = fitting
    for trait in TRAITS:
        values = list(dict.fromkeys(getattr(each, trait) for each in left))
        chosen = values[0] if len(values) == 1 else choose(trait, values)
        left = [each for each in left if getattr(each, trait) == chosen]
    return left[0]


def starter(
    below: str, answers: Answers, title: str, ask: Callable[[str, str], str] | None = None
) -> str:
    """The text of a scenario over the bundled ``below``; ``ask`` takes a question and its default.

    Raises:
        InputError: an answer cannot be used; the sentence is the scenario reader's.
    """
    from cosim.reading import load

    scenario = load(below)
    duration = answers.duration
    if duration is None and ask is not None:
        duration = ask("Duration", f"{float(scenario.duration):g} s")
    channels = _channels(answers, scenario, ask)
    objects = [name for name, part in scenario.components.items() if part.source in HOLDERS]
    mass = None if answers.mass is None else f"{answers.mass:g} kg"
    if mass is None and ask is not None:
        written = scenario.components[objects[0]].parameters.get("mass", MASS)
        mass = ask("Mass of the object", f"{written} kg")
    sets = [f"duration={duration}"] if duration else []
    sets += [f"channels.{c}.{key}={value}" for c in scenario.channels for key, value in channels]
    sets += [f"components.{part}.parameters.mass={mass}" for part in objects if mass]
    load(below, sets=sets)  # refused here, and nothing is written

    lines = [
        "cohaptic: 1",
        f"title: {json.dumps(title, ensure_ascii=False)}",
        f"include: {below}    # everything that is not said here",
    ]
    lines += [f"duration: {duration}"] if duration else []
    if channels:
        content = ", ".join(f"{key}: {value}" for key, value in channels)
        lines += ["", "channels:", *(f"  {each}: {{{content}}}" for each in scenario.channels)]
    if mass:
        lines += ["", "components:"]
        lines += [f"  {part}: {{parameters: {{mass: {mass}}}}}" for part in objects]
    return "\n".join(lines) + "\n"


def _channels(
    answers: Answers, scenario: Scenario, ask: Callable[[str, str], str] | None
) -> list[tuple[str, str]]:
    """What every channel gets."""
    if not scenario.channels:
        if answers.delay or answers.loss:
            raise InputError("--delay and --loss are of a network, and a single user has none.")
        return []
    delay = None if answers.delay is None else str(answers.delay)
    loss = None if answers.loss is None else f"{answers.loss:g}"
    if ask is not None:
        delay = delay or ask("Round trip, in samples of the network", "1")
        loss = loss or ask("Share of the packets that is lost", "0")
    found = [("round_trip_delay", delay), ("loss", loss)]
    return [(key, value) for key, value in found if value is not None]
