"""What a peer is given: the system of ``systems.py`` again, in the peers' own environment."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any


class CannotError(Exception):
    """What this master has no way to do; the sentence is shown in its row."""


@dataclass
class System:
    step: float
    ticks: int
    parts: list[dict[str, Any]]
    joins: list[list[str]]
    watched: list[list[str]]

    def need_one_rate(self, who: str) -> None:
        if any(part["every"] != 1 for part in self.parts):
            raise CannotError(f"{who} steps all FMUs at one rate")

    @property
    def slowest(self) -> int:
        return max(part["every"] for part in self.parts)

    @property
    def prefixed(self) -> list[str]:
        """The watched variables as ``part::variable``."""
        return [f"{part}::{variable}" for part, variable, _ in self.watched]


def serve(run: Any) -> None:
    """``SCRIPT SYSTEM [RECORD]``: print the loop's processor time (s), and the last values."""
    system = System(**json.loads(Path(sys.argv[1]).read_text()))
    record = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    try:
        seconds, values = run(system, record)
        answer = {"seconds": seconds, "values": values}
    except CannotError as error:
        answer = {"cannot": str(error)}
    print("\n" + json.dumps(answer), flush=True)
