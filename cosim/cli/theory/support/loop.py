"""The loop that a theory command is about, and how it says so."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import click

from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.parameters import Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing

if TYPE_CHECKING:
    from cosim.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Loop:
    """The loop that the options describe.

    Attributes:
        parameters: its parameters, by the thesis's names.
        timing: its rates and delays.
        notes: sentences about how it was read, for people.
        scenario: where the network comes from.
        says_delay: whether the options say a delay, which is then not the scenario's.
    """

    parameters: Parameters
    timing: Timing
    notes: tuple[str, ...] = ()
    scenario: Scenario | None = None
    says_delay: bool = False

    @property
    def architecture(self) -> Architecture:
        """single, centralized or distributed."""
        return self.parameters.architecture

    @property
    def model(self) -> Model:
        """The model with every user's hand in it."""
        return self.parameters.model()

    def timing_at(self, forward: int, backward: int) -> Timing:
        """The timing with another delay (network samples)."""
        return replace(self.timing, delay=PathDelay(forward, backward))

    def one_hand(self, user: int) -> Model:
        """The model with one user's hand alone (Fig. 6.1)."""
        users = self.parameters.users
        return self.parameters.model(tuple(m == user for m in range(users)))


def emit(result: Mapping[str, Any], text: str, *, as_json: bool, notes: tuple[str, ...]) -> None:
    """Print a result: one JSON object, or text; remarks go to stderr."""
    for note in notes:
        click.echo(note, err=True)
    click.echo(json.dumps(result, ensure_ascii=False) if as_json else text)


def describe(loop: Loop) -> str:
    """One line that says which loop a result is about."""
    timing = loop.timing
    if loop.architecture == "single":
        place = f"single user, T_c = 1/{1 / timing.control_period} s"
    else:
        place = (
            f"{loop.architecture}, {loop.parameters.users} users, "
            f"T_c = 1/{1 / timing.control_period} s, N = {timing.ratio}, "
            f"delay {timing.delay.forward} forward and {timing.delay.backward} backward"
        )
    if timing.computation_delay:
        place += f", computation delay {timing.computation_delay}"
    return place
