"""Figures 5.1 to 5.4: the planes that they show and what they hold fixed."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.stability.map import Axis


@dataclass(frozen=True, slots=True)
class StabilityFigure:
    """One figure of chapter 5; the printed axes are lost, the ranges are ours.

    Attributes:
        number: as in the thesis.
        architecture: which loop.
        fixed: what the figure holds, beside chapter 5's constants.
        horizontal: the parameter to the right and where it ends, N/m.
        vertical: the parameter upward and where it ends, N/m.
    """

    number: str
    architecture: Architecture
    fixed: dict[str, float]
    horizontal: tuple[str, float]
    vertical: tuple[str, float]

    def parameters(self) -> Parameters:
        """Chapter 5's constants with the figure's own."""
        return Parameters(self.architecture, self.fixed, CHAPTER_5[self.architecture])

    def axes(self, points: int = 201) -> tuple[Axis, Axis]:
        """The two axes with so many points each."""
        return Axis.even(*self.horizontal, points), Axis.even(*self.vertical, points)


FIGURES = {
    figure.number: figure
    for figure in (
        StabilityFigure("5.1", "centralized", {}, ("k_1", 25000.0), ("k_2", 3500.0)),
        StabilityFigure("5.2", "distributed", {"k_o": 1000.0}, ("k_11", 25000.0), ("k_12", 4000.0)),
        StabilityFigure("5.3", "distributed", {"k_12": 300.0}, ("k_11", 25000.0), ("k_o", 12000.0)),
        StabilityFigure("5.4", "distributed", {"k_11": 2000.0}, ("k_o", 12000.0), ("k_12", 4000.0)),
    )
}
DELAYS = (0, 1, 2, 3)
"""Round-trip delays of the figures, in network samples."""
