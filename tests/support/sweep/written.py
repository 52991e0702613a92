"""The table that ``cohaptic sweep`` has left in a sweep's folder."""

from __future__ import annotations

import csv
import importlib
from pathlib import Path
from typing import Any

OF_A_DAY = {"seconds"}
"""What may differ from one sweep to an equal one."""


def table_in(folder: Path) -> list[dict[str, Any]]:
    """The rows of ``results.parquet`` or ``results.csv``, without what differs from day to day."""
    file = next(file for file in sorted(folder.glob("results.*")) if file.suffix != ".jsonl")
    if file.suffix == ".parquet":
        rows = importlib.import_module("pyarrow.parquet").read_table(file).to_pylist()
    else:
        with file.open(newline="", encoding="utf-8") as lines:
            rows = list(csv.DictReader(lines))
    return [{key: cell for key, cell in row.items() if key not in OF_A_DAY} for row in rows]
