"""What a page says of a loop: whether it is stable, and its slowest motion; or why nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.timing import Timing
from cosim.theory.numerics import Complex
from cosim.theory.stability.spectral_radius import stability

LEAST_GROWTH, MOST_GROWTH = 1e-3, 1e3
"""What a mode's growth over one period is told as at least and at most."""


@dataclass(frozen=True, slots=True)
class ToldLoop:
    """One architecture of a scenario, as chapters 3 to 6 have it.

    Attributes:
        name: ``distributed``, ``centralized``, or empty where there is one alone.
        notes: what was left out, a sentence each.
        refusal: why nothing can be said, a sentence; empty where something is.
        radius: spectral radius over one network period.
        period: the network period (s).
        growth: of the slowest motion, a second.
        frequency: of the slowest motion (Hz); 0 where it does not swing.
        is_marginal: whether momentum is conserved, so that the common velocity is left out.
    """

    name: str
    notes: tuple[str, ...] = ()
    refusal: str = ""
    radius: float = math.nan
    period: float = math.nan
    growth: float = math.nan
    frequency: float = math.nan
    is_marginal: bool = False

    @property
    def is_stable(self) -> bool:
        """Whether a disturbance dies away."""
        return self.radius < 1.0


def tell(name: str, model: Model, timing: Timing, notes: tuple[str, ...] = ()) -> ToldLoop:
    """The radius of a loop and its slowest motion."""
    found = stability(model, timing)
    hyperperiod = float(timing.control_period * timing.ratio.numerator)
    ((growth, frequency), *_) = slowest_motions(found.spectrum.values, hyperperiod, 1)
    return ToldLoop(
        name,
        notes,
        radius=found.spectral_radius,
        period=float(timing.control_period * timing.ratio),
        growth=growth,
        frequency=frequency,
        is_marginal=found.marginal,
    )


def slowest_motions(eigenvalues: Complex, period: float, count: int) -> list[tuple[float, float]]:
    """Growth a second and frequency (Hz) of the largest eigenvalues, one of each pair.

    Args:
        eigenvalues: of the map over ``period`` (s), largest first.
        period: of the map (s).
        count: how many at most.
    """
    values = eigenvalues[eigenvalues.imag >= 0.0][:count]
    growth = np.clip(np.abs(values), LEAST_GROWTH, MOST_GROWTH) ** (1.0 / period)
    hertz = np.angle(values) / (2 * np.pi * period)
    return [(float(g), float(f)) for g, f in zip(growth, hertz, strict=True)]
