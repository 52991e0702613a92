"""What the commands say of a run: its radius, and where it was asked."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from cosim.analysis.answers.asked import AskedRun
from cosim.analysis.answers.chance import own_chance
from cosim.analysis.answers.names import closed_form_of
from cosim.theory.models.parameters import Parameters


@dataclass(frozen=True, slots=True)
class RunAnswer:
    """Whether a run is stable.

    Attributes:
        kind: "spectral radius", or "mean-square radius" where packets are lost or late by chance.
        radius: over ``period`` (s).
        stable: below 1.
        verdict: stable, neutral (1 as far as can be told) or unstable.
        marginal: momentum is conserved.
        neutral: how many motions are neutral whatever the gains.
        further: what else a program may want.
    """

    kind: str
    radius: float
    stable: bool
    verdict: str
    marginal: bool
    neutral: int
    period: Fraction
    further: dict[str, Any]

    def result(self) -> dict[str, Any]:
        """The JSON object."""
        key = self.kind.replace(" ", "_").replace("-", "_")
        return {
            key: self.radius,
            "stable": self.stable,
            "verdict": self.verdict,
            "marginal": self.marginal,
            "neutral_motions": self.neutral,
            "period": float(self.period),
            **self.further,
        }


def of_run(asked: AskedRun) -> RunAnswer:
    """The radius that decides: of the map, or of second moments where packets draw their fates."""
    point = asked.point()
    found = point.spectrum()
    further = about(asked)
    chance = own_chance(point)
    if chance is None:
        return RunAnswer(
            "spectral radius",
            found.radius,
            found.stable,
            found.verdict,
            found.marginal,
            found.neutral,
            found.period,
            further,
        )
    radius = chance.radius()
    return RunAnswer(
        "mean-square radius",
        radius,
        radius < 1.0,
        "stable" if radius < 1.0 else "unstable",
        found.marginal,
        found.neutral,
        point.seconds,
        further,
    )


def about(asked: AskedRun) -> dict[str, Any]:
    """What a run is, for programs: where it was asked, and the closed form's names for it."""
    point = asked.point()
    found: dict[str, Any] = {
        "tick": point.tick,
        "at": float(asked.scenario.start_time + point.tick / asked.scenario.base_rate),
        "coordinates": point.run.size,
        "architecture": "run",
    }
    loop = closed_form_of(asked.scenario)
    if loop is not None:
        parameters = Parameters(loop.architecture, loop.values, {}, loop.users)
        found |= {"architecture": loop.architecture, "parameters": parameters.resolved()}
    return found


def place(asked: AskedRun) -> str:
    """One line that says which run, and where in it."""
    point = asked.point()
    scenario = asked.scenario
    delays = [
        f"{name} {float(c.forward.delay.ticks / scenario.base_rate) * 1e3:.4g} ms there and "
        f"{float(c.backward.delay.ticks / scenario.base_rate) * 1e3:.4g} ms back"
        for name, c in scenario.channels.items()
    ]
    at = float(scenario.start_time + point.tick / scenario.base_rate)
    where = f"{scenario.name}, the run at {at:.6g} s ({point.run.size} numbers)"
    return f"{where}, {'; '.join(delays)}" if delays else where
