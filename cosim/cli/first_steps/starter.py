"""A starter scenario: a bundled one included, and over it what was asked for."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from cosim.base.errors import InputError
from cosim.base.quantities.quantity import quantity

Ask = Callable[[str, str, Callable[[str], None]], str]
"""Puts a question with its default until an answer is none that is refused."""


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
DELAY, LOSS = "round_trip_delay", "loss"
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


def starter(below: str, answers: Answers, title: str, ask: Ask | None = None) -> str:
    """The text of a scenario over the bundled ``below``; what is open is ``ask``-ed for.

    Raises:
        InputError: an answer cannot be used; the sentence is the scenario reader's.
    """
    from cosim.reading import load

    scenario = load(below)
    channels, parts = list(scenario.channels), scenario.components
    objects = [name for name, part in parts.items() if part.source in HOLDERS]
    if not channels and (answers.delay or answers.loss):
        raise InputError("--delay and --loss are of a network, and a single user has none.")

    def wanted(given: str | None, question: str, default: str, places: Sequence[str]) -> str | None:
        def judge(answer: str) -> None:
            load(below, sets=[f"{place}={answer}" for place in places])

        if given is None and ask is not None and places:
            return ask(question, default, judge)
        if given is not None:
            judge(given)
        return given

    length = f"{float(scenario.duration):g} s"
    duration = wanted(answers.duration, "Duration", length, ["duration"])
    delays, losses = ([f"channels.{c}.{key}" for c in channels] for key in (DELAY, LOSS))
    delay = None if answers.delay is None else str(answers.delay)
    delay = wanted(delay, "Round trip, in samples of the network", "1", delays)
    loss = None if answers.loss is None else f"{answers.loss:g}"
    loss = wanted(loss, "Share of the packets that is lost", "0", losses)
    mass = None if answers.mass is None else f"{answers.mass:g} kg"
    written = "" if not objects else _mass_of(parts[objects[0]].parameters.get("mass", MASS))
    masses = [f"components.{part}.parameters.mass" for part in objects]
    mass = wanted(mass, "Mass of the object", written, masses)

    lines = [
        "cohaptic: 1",
        f"title: {json.dumps(title, ensure_ascii=False)}",
        f"include: {below}    # everything that is not said here",
    ]
    lines += [f"duration: {duration}"] if duration else []
    said = [(key, value) for key, value in ((DELAY, delay), (LOSS, loss)) if value]
    if channels and said:
        content = ", ".join(f"{key}: {value}" for key, value in said)
        lines += ["", "channels:", *(f"  {each}: {{{content}}}" for each in channels)]
    if mass:
        lines += ["", "components:"]
        lines += [f"  {part}: {{parameters: {{mass: {mass}}}}}" for part in objects]
    return "\n".join(lines) + "\n"


def _mass_of(written: Any) -> str:
    """A mass as a scenario has it, in whatever unit, in kg."""
    return f"{float(quantity(written, 'kg')):g} kg"
