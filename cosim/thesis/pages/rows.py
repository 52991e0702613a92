"""A statement's evidence and ablations as rows of a table, the same on every page."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.thesis.claims.verdict import Decided, Measured
from cosim.thesis.pages.phrases import limit, number


@dataclass(frozen=True, slots=True)
class Row:
    """One expectation of one run; ``bad`` is what speaks against the statement."""

    meaning: str
    run: str
    signal: str
    limit: str
    measured: str
    bad: bool = False
    must_fail: bool = False


def rows(item: Decided) -> list[Row]:
    """Evidence first, then of each ablation the limits that it misses."""
    found: list[Row] = []
    for evidence, measured in zip(item.statement.evidence, item.measured, strict=True):
        found += _evidence(measured, evidence.run)
    for each, measured in zip(item.statement.ablations, item.ablated, strict=True):
        found += _ablation(measured, each.name)
    return found


def _evidence(measured: Measured, run: str) -> list[Row]:
    meaning = measured.evidence.meaning
    if not measured.found:
        return [Row(meaning, run, "", "", _nothing(measured), bad=True)]
    return [
        Row(
            meaning,
            run,
            str(one["target"]),
            limit(one),
            number(one["measured"], one["unit"]),
            bad=not one["passed"],
        )
        for one in measured.found
    ]


def _ablation(measured: Measured, run: str) -> list[Row]:
    meaning = measured.evidence.meaning
    missed = [one for one in measured.found if not one["passed"]]
    if not missed:
        words = "holds as well: the limits could not have failed"
        said = words if measured.found else _nothing(measured)
        return [Row(meaning, run, "", "", said, bad=True, must_fail=True)]
    return [
        Row(
            meaning,
            run,
            str(one["target"]),
            f"not {limit(one)}",
            number(one["measured"], one["unit"]),
            must_fail=True,
        )
        for one in missed
    ]


def _nothing(measured: Measured) -> str:
    return "not measured" + (f": {measured.failure}" if measured.failure else "")
