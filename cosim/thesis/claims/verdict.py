"""Statements held against the summaries of the runs: agree, disagree, cannot be decided."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from cosim.thesis.claims.statement import Evidence, Statement

Verdict = Literal["agree", "disagree", "cannot be decided"]


@dataclass(frozen=True, slots=True)
class Measured:
    """One piece of evidence with what was measured; ``found`` is empty where nothing was."""

    evidence: Evidence
    found: tuple[Mapping[str, Any], ...]
    failure: str = ""

    @property
    def passed(self) -> bool | None:
        """Whether every expectation held; ``None`` where nothing was measured."""
        if self.failure or not self.found:
            return None
        if any(entry["measured"] is None for entry in self.found):
            return None
        return all(entry["passed"] for entry in self.found)


@dataclass(frozen=True, slots=True)
class Decided:
    """A statement with its evidence, and with the ablations that had to fail."""

    statement: Statement
    measured: tuple[Measured, ...]
    ablated: tuple[Measured, ...] = ()

    @property
    def verdict(self) -> Verdict:
        """Agree where all evidence holds and every ablation fails it."""
        if self.statement.undecidable:
            return "cannot be decided"
        passed = [item.passed for item in self.measured]
        if any(value is False for value in passed):
            return "disagree"
        could_fail = bool(self.ablated) and all(item.passed is False for item in self.ablated)
        return "agree" if passed and all(passed) and could_fail else "cannot be decided"


def decide(
    summaries: Mapping[str, Mapping[str, Any]],
    failures: Mapping[str, str],
    statements: Sequence[Statement],
) -> Sequence[Decided]:
    """Hold statements against the summaries of the runs, by their names."""

    def measured(evidence: Evidence, run: str) -> Measured:
        entries = summaries.get(run, {}).get("expectations", ())
        found = tuple(entry for entry in entries if entry["label"] == evidence.label)
        return Measured(evidence, found, failures.get(run, ""))

    return [
        Decided(
            statement,
            tuple(measured(evidence, evidence.run) for evidence in statement.evidence),
            tuple(measured(each.evidence, each.name) for each in statement.ablations),
        )
        for statement in statements
    ]
