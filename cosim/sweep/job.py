"""What a worker is told: the scenario as it is written, what to look at, and points."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from cosim.scenario.load import Written
from cosim.sweep.planning.axis import SweepAxis, Value

Reading = tuple[str, str]
"""A target (a signal, a difference, a length) and a measure of it, such as ``max_abs``."""


@dataclass(frozen=True, slots=True)
class Job:
    """A sweep without its points; can be sent to another process."""

    written: Written
    axes: tuple[SweepAxis, ...]
    readings: tuple[Reading, ...] = ()
    """What is measured besides the scenario's own measures and expectations."""
    start: str | None = None
    """The time from which points differ; everything before is run once, as the scenario has it."""
    check_every: int = 100
    """Every so many runs of a worker, one is repeated from nothing and compared; 0: never."""

    def overrides(self, point: Sequence[Value]) -> list[str]:
        """What ``--set`` would be given for a point."""
        return [
            override(place, value)
            for axis, value in zip(self.axes, point, strict=True)
            for place in axis.places
        ]


@dataclass(frozen=True, slots=True)
class Task:
    """One point to run."""

    number: int
    point: tuple[Value, ...]
    key: str = ""
    """What it is kept under; of equal content, whatever its number."""


@dataclass(frozen=True, slots=True)
class RunResult:
    """What came out of one run.

    ``status`` is ``good``, ``failed`` (an expectation was not met, or a signal ran away), ``error``
    (the run ended early), ``refused`` (these values cannot be used) or ``crashed`` (its process
    died).
    """

    number: int
    key: str
    point: tuple[Value, ...]
    status: str
    message: str = ""
    measures: Mapping[str, float] = field(default_factory=dict[str, float])
    """By name, SI units: the scenario's measures, readings, and what expectations looked at."""
    passed: Mapping[str, bool] = field(default_factory=dict[str, bool])
    """Each expectation by its text."""
    ticks: int = 0
    seconds: float = 0.0
    """Wall time of the loop."""
    checked: bool = False
    """Whether a run from nothing was compared, and was equal."""

    @property
    def is_good(self) -> bool:
        """Whether all that was expected came."""
        return self.status == "good"

    @property
    def is_over(self) -> bool:
        """Whether the run came to its end, whatever its verdict."""
        return self.status in {"good", "failed"}

    def as_dict(self) -> dict[str, Any]:
        """For JSON."""
        return {name: getattr(self, name) for name in self.__slots__}


def override(place: str, value: Value) -> str:
    """A value at a place, as ``--set`` takes it."""
    if isinstance(value, bool):
        return f"{place}={'true' if value else 'false'}"
    return f"{place}={value if isinstance(value, str) else repr(value)}"
