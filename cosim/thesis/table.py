"""The statements as a table of docs/experiments.md: evidence, ablations, verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cosim.thesis.page import limit, number
from cosim.thesis.predictions import PREDICTIONS
from cosim.thesis.statements import Decided, Measured

BEGIN, END = "<!-- statements, written by a test -->", "<!-- end of statements -->"


def statements_table(decided: Sequence[Decided]) -> str:
    """Markdown between ``BEGIN`` and ``END``, both included."""
    rows = [
        "| statement | expected: measured (origin) | ablation: what it misses | verdict |",
        "|---|---|---|---|",
    ]
    for item in decided:
        evidence = "<br>".join(_evidence(measured) for measured in item.measured)
        ablated = "<br>".join(_ablation(measured) for measured in item.ablated)
        rows.append(f"| {item.statement.claim} | {evidence} | {ablated} | {item.verdict} |")
    return "\n".join([BEGIN, *rows, END])


def with_table(page: str, decided: Sequence[Decided]) -> str:
    """The page with its table renewed."""
    before, _, rest = page.partition(BEGIN)
    return before + statements_table(decided) + rest.partition(END)[2]


def _evidence(measured: Measured) -> str:
    found = [_entry(one) for one in measured.found]
    origin = PREDICTIONS[measured.evidence.scenario, measured.evidence.label].origin
    return f"{measured.evidence.meaning}: {'; '.join(found) or 'not measured'} ({origin})"


def _ablation(measured: Measured) -> str:
    found = [_entry(one) for one in measured.found if not one["passed"]]
    return f"{measured.evidence.meaning}: {'; '.join(found) or 'nothing'}"


def _entry(one: Mapping[str, Any]) -> str:
    return f"`{one['target']}` {limit(one)}: {number(one['measured'], one['unit'])}"
