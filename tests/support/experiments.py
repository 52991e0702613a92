"""The stored numbers of docs/experiments.md, and those of a run beside them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

PAGE = Path(__file__).parents[2] / "docs" / "experiments.md"
NUMBERS = PAGE.with_suffix(".json")


def measured_of(summary: Mapping[str, Any]) -> dict[tuple[str, str, str], Any]:
    """What was measured under a label, by target, label and predicate."""
    return {
        (one["target"], one["label"], one["predicate"]): one["measured"]
        for one in summary["expectations"]
        if one["label"]
    }
