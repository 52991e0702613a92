"""How bounds of a joint spectral radius are said."""

from __future__ import annotations

from collections.abc import Sequence

from cosim.theory.robust.automaton import Automaton
from cosim.theory.robust.joint_radius import JointRadius


def result_of(
    found: JointRadius, automaton: Automaton, events: Sequence[Sequence[int]]
) -> dict[str, object]:
    """The JSON object: bounds, and the events on every link in the worst known order."""
    return {
        "verdict": found.verdict,
        "lower": found.lower,
        "upper": found.upper,
        "quadratic": found.quadratic,
        "worst": [list(events[number]) for number in found.word],
        "maps": len(automaton.maps),
        "nodes": automaton.nodes,
    }


SENTENCES = {
    "stable": "stable, whatever comes",
    "unstable": "unstable, by the order below",
    "undecided": "undecided: the bounds lie on both sides of 1",
}


def sentence(found: JointRadius) -> str:
    """The bounds, for people."""
    return (
        f"joint spectral radius {found.lower:.6f} to {found.upper:.6f} per network period "
        f"(common quadratic norms alone prove {found.quadratic:.6f}): {SENTENCES[found.verdict]}"
    )
