"""Numbers and tables of the page: how they are computed and how they are written."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.parameters import CHAPTER_5, TABLE_6_1, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability, stable_intervals
from cosim.theory.transparency.damping import DampingModel, limit_damping

Row = Sequence[str]


def table(head: Row, rows: Sequence[Row]) -> str:
    """A table as Markdown."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join(row) + " |" for row in rows]
    return "\n".join(lines)


def timing(n: int = 0, ratio: int = 8, computation_delay: int = 0) -> Timing:
    """A round trip of ``n`` samples, ``ratio`` control ticks a sample."""
    return Timing(
        ratio=Fraction(ratio), delay=PathDelay.round_trip(n), computation_delay=computation_delay
    )


def limits(
    architecture: Architecture,
    given: dict[str, float],
    vary: str,
    of: Timing,
    high: float = 50000.0,
) -> list[tuple[float, float]]:
    """Stable intervals of one parameter from 1 N/m up, chapter 5's constants elsewhere."""
    base = Parameters(architecture, given, CHAPTER_5[architecture])

    def radius(value: float) -> float:
        return stability(base.replaced({vary: value}).model(), of).spectral_radius

    return stable_intervals(radius, 1.0, high, points=80)


def digits(value: float, places: int = 4) -> str:
    """A number with so many significant digits, never with an exponent."""
    rounded = float(f"{value:.{places}g}")
    return np.format_float_positional(rounded, trim="-", min_digits=0).rstrip(".")


def signed(value: float) -> str:
    """Three decimals with a true minus sign."""
    return f"{value:.3f}".replace("-", "−")


def highest(intervals: list[tuple[float, float]]) -> str:
    """The upper end of the last interval, a dash where there is none."""
    return digits(intervals[-1][1]) if intervals else "–"


def one_hand(architecture: Architecture, **given: float) -> tuple[Model, int]:
    """The model of Fig. 6.1 and who feels it."""
    user = 1 if architecture == "centralized" else 0
    parameters = Parameters(architecture, given, TABLE_6_1[architecture])
    return parameters.model((user == 0, user == 1)), user


def damping_felt(
    architecture: Architecture,
    n: int = 0,
    ratio: int = 8,
    kind: DampingModel = "original",
    **given: float,
) -> float:
    """Damping (N·s/m) that the user of Fig. 6.1 feels in the limit of slow motion."""
    model, user = one_hand(architecture, **given)
    return limit_damping(model, timing(n, ratio), user, kind)
