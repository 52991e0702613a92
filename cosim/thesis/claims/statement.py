"""What a statement is: which expectations of which runs decide it, and which must fail.

A statement names labels of ``expect:`` entries in ``scenarios/thesis``, and ablations: the same
runs without what the statement says matters, in which the same expectations must not hold. It is
agreed with when all evidence holds and every ablation fails, disagreed with when evidence that was
measured does not hold, and cannot be decided otherwise: where an ablation passes, the limits would
have been met anyway.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

Runs = dict[str, tuple[str, tuple[str, ...]]]
"""Name of a run -> scenario file and overrides."""


@dataclass(frozen=True, slots=True)
class Evidence:
    """The expectations with one label in one scenario, and what they mean to the statement.

    Where their limits come from is in ``cosim.thesis.expected.predictions``. ``sets`` make it
    another run than the scenario's own, called ``name``.
    """

    scenario: str
    label: str
    meaning: str
    name: str = ""
    sets: tuple[str, ...] = ()

    @property
    def run(self) -> str:
        """Name of the run whose summary has the expectations."""
        return self.name or self.scenario


@dataclass(frozen=True, slots=True)
class Ablation:
    """A run of the evidence without what matters: the label's expectations must not all hold."""

    name: str
    evidence: Evidence
    sets: tuple[str, ...]


def ablation(scenario: str, label: str, meaning: str, *sets: str, number: int = 1) -> Ablation:
    """One that is called after its scenario."""
    name = f"{scenario}_without" + (f"_{number}" if number > 1 else "")
    return Ablation(name, Evidence(scenario, label, meaning), sets)


def both_copies(**values: float | str) -> tuple[str, ...]:
    """Overrides of both distributed workstations."""
    return tuple(
        f"components.vr_{which}.parameters.{name}={value}"
        for which in "ab"
        for name, value in values.items()
    )


def server(**values: float | str) -> tuple[str, ...]:
    """Overrides of the central server."""
    return tuple(f"components.server.parameters.{name}={value}" for name, value in values.items())


@dataclass(frozen=True, slots=True)
class Statement:
    """One claim in our words, with its section of the thesis and what decides it.

    Where the claim is not the thesis's, ``section`` is empty and the claim says whose it is.
    ``undecidable`` says why no simulation can decide it; empty where one can.
    """

    name: str
    section: str
    claim: str
    evidence: tuple[Evidence, ...]
    remark: str = ""
    ablations: tuple[Ablation, ...] = ()
    undecidable: str = ""


def runs_of(statements: Sequence[Statement]) -> Runs:
    """Every run that the statements need, evidence before ablations, each once."""
    evidence = {
        each.run: (f"thesis/{each.scenario}", each.sets)
        for statement in statements
        for each in statement.evidence
    }
    return evidence | {
        each.name: (f"thesis/{each.evidence.scenario}", each.sets)
        for statement in statements
        for each in statement.ablations
    }
