"""The virtual couplers of a single-axis scenario: which bodies each ties, and by which wires."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from cosim.analysis.wires import INSTEAD, Wire
from cosim.base.errors import InputError
from cosim.scenario import Scenario, ScenarioComponent

_ONTO = {"a": "reaction", "b": "force"}
"""The coupler's output that acts on the body at each of its ends."""


@dataclass(frozen=True, slots=True)
class Tie:
    """A coupler between a body that may be far (``other``) and the object of its own station.

    ``near`` is the coupler's end at its own object: ``a`` or ``b``.
    """

    coupler: ScenarioComponent
    other: str
    own: str
    near: str


def wires_of(
    ties: Sequence[Tie], hands: Mapping[str, ScenarioComponent], *, distributed: bool
) -> set[Wire]:
    """Every connection of the loop: what couplers see, and what they act on.

    A distributed copy is pulled by what its peers sent, and pulls none of them.
    """
    found: set[Wire] = set()
    for tie in ties:
        name, near = tie.coupler.name, tie.near
        far = "b" if near == "a" else "a"
        for kind in ("position", "velocity"):
            found.add((f"{tie.own}.{kind}", f"{name}.{kind}_{near}"))
            found.add((f"{tie.other}.{kind}", f"{name}.{kind}_{far}"))
        found.add((f"{name}.{_ONTO[near]}", f"{tie.own}.force"))
        hand = hands.get(tie.other)
        if hand is not None and (not distributed or hand.station == tie.coupler.station):
            found.add((f"{name}.{_ONTO[far]}", f"{tie.other}.coupler_force"))
    return found


def refuse_double_ties(scenario: Scenario, ties: Sequence[Tie]) -> None:
    """Refuse two couplers between the same bodies, of which the loop has one.

    Raises:
        InputError: with the place of the second.
    """
    seen: dict[tuple[str, str], str] = {}
    for tie in ties:
        first = seen.setdefault((tie.own, tie.other), tie.coupler.name)
        if first != tie.coupler.name:
            raise InputError(
                f"{first} and {tie.coupler.name} both join {tie.other} and {tie.own}, and the loop "
                f"of chapters 3 to 6 has one coupler there; {INSTEAD}.",
                scenario.locate(("components", tie.coupler.name)),
            )


def refuse_other_copies(
    scenario: Scenario, ties: Sequence[Tie], copies: Sequence[ScenarioComponent]
) -> None:
    """Refuse a copy that is not coupled to all others alike: it has one k_o and one b_o.

    Raises:
        InputError: with the place of the copy or of the coupler.
    """
    names = {body.name for body in copies}
    for body in copies:
        own = [t for t in ties if t.own == body.name and t.other in names]
        if own and len(own) != len(copies) - 1:
            raise InputError(
                f"{body.name} is coupled to {len(own)} of {len(copies) - 1} other copies, and the "
                f"loop of chapters 3 to 6 couples it to all or to none; {INSTEAD}.",
                scenario.locate(("components", body.name)),
            )
        for tie in own[1:]:
            if dict(tie.coupler.parameters) != dict(own[0].coupler.parameters):
                raise InputError(
                    f"{own[0].coupler.name} and {tie.coupler.name} couple {body.name} to the other "
                    f"copies differently, and the loop of chapters 3 to 6 has one k_o and b_o a "
                    f"copy; {INSTEAD}.",
                    scenario.locate(("components", tie.coupler.name)),
                )


def refuse_other_places(
    scenario: Scenario, hands: Sequence[ScenarioComponent], home: str, numbers: Mapping[str, int]
) -> None:
    """Refuse hands that are not where those of a single or centralized loop are.

    User 1 is at the object's station, and everyone else is not.

    Raises:
        InputError: with the hand's place.
    """
    for hand in hands:
        if (hand.station == home) != (numbers[hand.name] == 1):
            raise InputError(
                f"{hand.name} is at {hand.station} and the object at {home}: in a loop of chapters "
                f"3 to 6 that has one object user 1 alone is there; {INSTEAD}.",
                scenario.locate(("components", hand.name)),
            )
