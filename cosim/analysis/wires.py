"""Whether parts are joined as a loop of chapters 3 to 6 has them: each connection, and no other."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from functools import cache

from cosim.analysis.parameter import layout_of
from cosim.base.errors import InputError
from cosim.scenario import Connection, Scenario, ScenarioComponent

Wire = tuple[str, str]
"""An output and what it drives, ``component.variable`` each; of an array without its element."""

INSTEAD = "ask for the run itself (theory radius, modes, boundary, margins, loss)"


def refuse_other_wires(
    scenario: Scenario, loop: Collection[str], wanted: Collection[Wire], pushed: Collection[str]
) -> None:
    """Refuse a scenario whose loop is joined otherwise.

    Args:
        scenario: what is read.
        loop: the names of the parts of the loop.
        wanted: its connections.
        pushed: inputs that something outside the loop may drive.

    Raises:
        InputError: a connection is missing, twice, or one too many, or it scales what it carries.
    """
    found: set[Wire] = set()
    for number, link in enumerate(scenario.connections):
        if link.target.component not in loop:
            continue
        place = scenario.locate(("connections", number))
        target = f"{link.target.component}.{link.target.path.partition('[')[0]}"
        if target in pushed and _is_open(scenario, link):
            continue
        wire = (str(link.source), target)
        if wire not in wanted:
            raise InputError(
                f"{link}: the loop of chapters 3 to 6 has no such connection; {INSTEAD}.", place
            )
        if wire in found:
            raise InputError(f"{link}: the loop of chapters 3 to 6 has it once.", place)
        found.add(wire)
    refuse_scaled(scenario, loop)
    for source, target in sorted(set(wanted) - found):
        raise InputError(
            f"Nothing goes from {source} to {target}, as in the loop of chapters 3 to 6; "
            f"{INSTEAD}.",
            scenario.locate(("connections",)),
        )


def _is_open(scenario: Scenario, link: Connection) -> bool:
    """Whether nothing comes back to the source of a connection."""
    return all(other.target.component != link.source.component for other in scenario.connections)


def refuse_scaled(scenario: Scenario, loop: Collection[str]) -> None:
    """Refuse connections into the loop that change the number they carry.

    Raises:
        InputError: by name and place.
    """
    for number, link in enumerate(scenario.connections):
        if link.target.component in loop and (link.factor, link.offset) != (1.0, 0.0):
            raise InputError(
                f"{link} has a factor or an offset, which the loop of chapters 3 to 6 leaves out; "
                f"{INSTEAD}.",
                scenario.locate(("connections", number)),
            )


def refuse_other_steps(scenario: Scenario, parts: Collection[ScenarioComponent]) -> None:
    """Refuse parts that step otherwise than a loop of chapters 3 to 6: a tick late, or in pieces.

    Raises:
        InputError: by name and place.
    """
    for part in parts:
        for key, is_other in (
            ("feedthrough", part.feedthrough is False),
            ("substeps", part.substeps != 1),
        ):
            if is_other:
                raise InputError(
                    f"{part.name} has '{key}', which the loop of chapters 3 to 6 leaves out; "
                    f"{INSTEAD}.",
                    scenario.locate(("components", part.name, key)),
                )


def turned_parameters(scenario: Scenario) -> Iterator[tuple[int, Connection]]:
    """The connections that turn a channel or a parameter of one of our models, with their place."""
    for number, link in enumerate(scenario.connections):
        name = link.target.component
        if name in scenario.channels:
            yield number, link
            continue
        part = scenario.components[name]
        if part.is_bundled and _is_tunable(part.source, link.target.path.partition("[")[0]):
            yield number, link


@cache
def _is_tunable(model: str, path: str) -> bool:
    """Whether a path stands for a parameter that may be turned, or for a group of nothing else."""
    named = [
        placed.variable.tunable
        for placed in layout_of(model).placed
        if placed.path == path or placed.path.startswith(f"{path}.")
    ]
    return bool(named) and all(named)
