"""Figures 6.2, 6.4, 6.5 and Tables 6.1, 6.2 as computations."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from cosim.theory.models.parameters import TABLE_6_1, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.numerics import Real
from cosim.theory.transparency.admittance import Case, Felt, Response, default_parameters, perceived
from cosim.theory.transparency.damping import DampingModel, limit_damping


@dataclass(frozen=True, slots=True)
class AdmittanceFigure:
    """One figure of chapter 6.

    Attributes:
        number: as in the thesis.
        title: what it shows.
        case: free motion or contact.
        curves: who feels it, one curve each.
    """

    number: str
    title: str
    case: Case
    curves: tuple[Felt, ...]

    def responses(self, frequencies: Real) -> dict[Felt, Response]:
        """Every curve at n = 1, the delay of the thesis's figures (frequencies in rad/s)."""
        timing = Timing(delay=PathDelay.round_trip(1))
        return {
            felt: perceived(default_parameters(felt), timing, felt, self.case, frequencies)
            for felt in self.curves
        }


FIGURES = {
    figure.number: figure
    for figure in (
        AdmittanceFigure(
            "6.2",
            "Perceived admittance V/F in free motion",
            "free",
            ("ideal", "local", "remote", "distributed"),
        ),
        AdmittanceFigure(
            "6.4",
            "Perceived admittance V/F before and after compensation",
            "free",
            ("ideal", "distributed", "compensated"),
        ),
        AdmittanceFigure(
            "6.5",
            "Perceived admittance X/F against a rigid wall",
            "contact",
            ("ideal", "local", "remote", "distributed"),
        ),
    )
}


def frequencies(points: int = 200) -> Real:
    """0.1 to 1000 rad/s, evenly spaced in the logarithm, rad/s."""
    return np.geomspace(0.1, 1000.0, points)


def table_6_1() -> list[dict[str, object]]:
    """Table 6.1: the parameters of chapter 6."""
    units = {"m": "kg", "k": "N/m", "b": "N·s/m"}
    architectures: tuple[Architecture, ...] = ("centralized", "distributed")
    return [
        {"architecture": architecture, "parameter": name, "value": value, "unit": units[name[0]]}
        for architecture in architectures
        for name, value in TABLE_6_1[architecture].items()
        if value
    ]


THESIS_TABLE_6_2 = {
    ("centralized", "original"): "0.04",
    ("centralized", "simplified"): "0",
    ("distributed", "original"): "2.1",
    ("distributed", "simplified"): "1.4",
}
"""As printed, in N·s/m."""


def table_6_2(ratio: int = 8) -> list[dict[str, object]]:
    """Table 6.2: damping by the original and the simplified model at n = 0, in N·s/m.

    Args:
        ratio: N; the thesis's caption says 8, its centralized number is that of 2.
    """
    rows: list[dict[str, object]] = []
    felt_by: dict[Architecture, int] = {"centralized": 1, "distributed": 0}
    kinds: tuple[DampingModel, ...] = ("original", "simplified")
    for architecture, user in felt_by.items():
        parameters = Parameters(architecture, {}, TABLE_6_1[architecture])
        model = parameters.model((user == 0, user == 1))
        for kind in kinds:
            damping = limit_damping(model, Timing(ratio=Fraction(ratio)), user, kind)
            rows.append(
                {
                    "architecture": architecture,
                    "model": kind,
                    "thesis": THESIS_TABLE_6_2[architecture, kind],
                    "damping": 0.0 if abs(damping) < 1e-9 else damping,
                }
            )
    return rows
