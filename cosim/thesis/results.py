"""What the runs and sweeps said, as one JSON file that pages are made from."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self, cast

from cosim.base.errors import InputError
from cosim.thesis.claims.statement import Runs, Statement
from cosim.thesis.claims.verdict import Decided, decide
from cosim.thesis.experiments import Ran
from cosim.thesis.sweeps.beyond import Beyond

DIGITS = 6
"""Significant ones that are kept."""
KEPT = ("target", "label", "predicate", "threshold", "unit", "measured", "passed")
"""Of an expectation."""


@dataclass(frozen=True, slots=True)
class Results:
    """``runs`` by name: file, overrides, title, failure, labelled expectations; and the sweeps."""

    runs: Mapping[str, Mapping[str, Any]]
    sweeps: Beyond

    @classmethod
    def of(cls, wanted: Runs, ran: Mapping[str, Ran], sweeps: Beyond) -> Self:
        """From the summaries of the runs, rounded to ``DIGITS``."""
        runs = {
            name: {
                "file": file,
                "sets": list(sets),
                "title": ran[name].summary.get("title", ""),
                "failure": ran[name].failure,
                "expectations": [
                    {key: _rounded(entry[key]) for key in KEPT}
                    for entry in ran[name].summary.get("expectations", ())
                    if entry["label"]
                ],
            }
            for name, (file, sets) in wanted.items()
        }
        return cls(runs, Beyond.of(_rounded(sweeps.as_json())))

    @classmethod
    def read(cls, path: Path) -> Self:
        """What ``text`` wrote.

        Raises:
            InputError: the file cannot be read or is no such file.
        """
        try:
            plain = json.loads(path.read_text(encoding="utf-8"))
            return cls(plain["runs"], Beyond.of(plain["sweeps"]))
        except (OSError, ValueError, KeyError) as error:
            raise InputError(f"{path} has no results of 'cohaptic thesis': {error}") from error

    def text(self) -> str:
        """As JSON."""
        plain = {"runs": self.runs, "sweeps": self.sweeps.as_json()}
        return json.dumps(plain, indent=1, ensure_ascii=False) + "\n"

    def decided(self, statements: Sequence[Statement]) -> Sequence[Decided]:
        """The statements held against these runs."""
        failures = {name: run["failure"] for name, run in self.runs.items() if run["failure"]}
        return decide(self.runs, failures, statements)


def _rounded(value: object) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, Mapping):
        return {key: _rounded(each) for key, each in cast("Mapping[str, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in cast("Sequence[Any]", value)]
    return value
