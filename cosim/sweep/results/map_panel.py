"""A map of two variables: the share of good runs in colours, and the theory's boundary over it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cosim.plot.style import COLOURS
from cosim.sweep.planning.axis import SweepAxis, number_of
from cosim.sweep.sweep import SweepOutcome

Numbers = NDArray[np.float64]
BOUNDARY = "theory: spectral radius 1"


@dataclass(frozen=True, slots=True)
class Scale:
    """What runs along one side of a map."""

    label: str
    values: Numbers
    is_log: bool = False

    @classmethod
    def of(cls, axis: SweepAxis) -> Scale:
        """A variable's, whose values are numbers."""
        label = f"{axis.name} ({axis.unit})" if axis.unit else axis.name
        return cls(label, np.array([number_of(v) for v in axis.values], dtype=float), axis.is_log)


@dataclass(frozen=True, slots=True)
class MapPanel:
    """What a map shows.

    ``shares``, of shape (up, across), is the share of good runs in each cell, NaN where none was
    run; ``radii``, of the same shape, the spectral radii, where the two variables alone say them.
    """

    across: Scale
    up: Scale
    shares: Numbers
    radii: Numbers | None = None

    def draw(self, plot: Any) -> Any:
        """Draw it into Matplotlib's axes; returns the mesh, for a scale of colours beside it."""
        plot.grid(visible=False)
        mesh = plot.pcolormesh(
            self.across.values,
            self.up.values,
            self.shares,
            cmap="cividis",
            vmin=0.0,
            vmax=1.0,
            shading="nearest",
        )
        if self._has_boundary:
            assert self.radii is not None
            plot.contour(
                self.across.values, self.up.values, self.radii, levels=[1.0], colors=[COLOURS[1]]
            )
            plot.plot([], [], color=COLOURS[1], label=BOUNDARY)
            plot.legend(loc="upper right", frameon=True)
        label(plot, self.across, self.up)
        return mesh

    @property
    def _has_boundary(self) -> bool:
        if self.radii is None or min(self.radii.shape) < 2 or np.isnan(self.radii).any():
            return False
        return bool(self.radii.min() < 1.0 <= self.radii.max())


def label(plot: Any, across: Scale, up: Scale) -> None:
    """Say what runs along the two sides."""
    plot.set_xscale("log" if across.is_log else "linear")
    plot.set_yscale("log" if up.is_log else "linear")
    plot.set_xlabel(across.label)
    plot.set_ylabel(up.label)


def panel_of(outcome: SweepOutcome, across: SweepAxis, up: SweepAxis) -> MapPanel:
    """The map of a sweep's grid.

    Points of a boundary that were not run count with the verdict of what surrounds them.
    """
    return MapPanel(Scale.of(across), Scale.of(up), *_cells(outcome, across, up))


def _cells(
    outcome: SweepOutcome, across: SweepAxis, up: SweepAxis
) -> tuple[Numbers, Numbers | None]:
    shape = len(up.values), len(across.values)
    places = [list(outcome.plan.axes).index(axis) for axis in (up, across)]
    numbers = [{value: i for i, value in enumerate(axis.values)} for axis in (up, across)]

    def cell(number: int) -> tuple[int, int]:
        point = outcome.plan.points[number]
        row, column = (of[point[place]] for of, place in zip(numbers, places, strict=True))
        return row, column

    verdicts = dict(outcome.verdicts or {})
    verdicts |= {result.number: result.is_good for result in outcome.results}
    counts = np.zeros((2, *shape))
    for number, good in verdicts.items():
        counts[:, *cell(number)] += (good, 1)
    with np.errstate(invalid="ignore"):
        shares = counts[0] / counts[1]
    if outcome.theory is None:
        return shares, None
    radii = np.full(shape, np.nan)
    for number, radius in enumerate(outcome.theory):
        place = cell(number)
        if not (np.isnan(radii[place]) or radii[place] == radius):
            return shares, None  # another variable has a say in it
        radii[place] = radius
    return shares, radii
