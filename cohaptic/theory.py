"""What the theory of chapters 3 to 6 says about a scenario; nothing is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import cosim.analysis.longest_delay as _longest
from cosim.analysis.longest_delay import LongestDelay
from cosim.base.errors import InputError
from cosim.reading import FORMS, scenario_of
from cosim.scenario import Scenario
from cosim.scenario.load import Written
from cosim.sweep import theory as _theory
from cosim.sweep.planning.plan import Request, plan_of
from cosim.sweep.theory import is_stable
from cosim.sweep.work.variants import Variants

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = [
    "LongestDelay",
    "RadiusMap",
    "is_stable",
    "longest_delay",
    "radius_map",
    "spectral_radius",
]


@dataclass(frozen=True, slots=True, eq=False)
class RadiusMap:
    """Spectral radii over a grid; below 1 the loop settles.

    ``axes`` has the values of each variable by its name, in the order of the dimensions of
    ``radii``.
    """

    axes: Mapping[str, tuple[Any, ...]]
    radii: NDArray[np.float64]

    def to_xarray(self) -> Any:
        """The same as an xarray data array.

        Raises:
            InputError: xarray is not installed.
        """
        try:
            from xarray import DataArray
        except ImportError:
            raise InputError("this needs xarray: pip install 'cohaptic[notebook]'.") from None
        coordinates = {name: list(values) for name, values in self.axes.items()}
        return DataArray(self.radii, coordinates, list(self.axes), name="spectral_radius")

    def __repr__(self) -> str:
        sizes = " x ".join(f"{name} ({len(values)})" for name, values in self.axes.items())
        stable = sum(map(is_stable, self.radii.ravel().tolist()))
        return f"Spectral radii over {sizes}: {stable} of {self.radii.size} settle"


def spectral_radius(scenario: str | Path | Scenario) -> float:
    """The spectral radius of a scenario's loop over one network period; below 1 it is stable.

    Raises:
        InputError: the scenario has no loop that chapters 3 to 6 know, its packets are lost or late
            by chance, something is turned while it runs, or a delay is no whole number of samples.
    """
    return _theory.spectral_radius(scenario_of(scenario))


def longest_delay(scenario: str | Path | Scenario) -> LongestDelay | None:
    """The longest delay each way that the scenario's loop stands, everyone holding on.

    ``None`` where chapters 3 to 6 do not know its loop.
    """
    return _longest.longest_delay(scenario_of(scenario))


def radius_map(scenario: str | Path | Scenario, vary: Mapping[str, Any]) -> RadiusMap:
    """The spectral radius at every point of a grid; ``vary`` as for ``cohaptic.sweep``.

    Raises:
        InputError: a place or value cannot be, or the scenario has no loop that the chapters know.
    """
    import numpy as np

    scenario = scenario_of(scenario)
    written = Written(scenario.file, scenario.root, FORMS)
    plan = plan_of(Request(scenario=written, vary=vary), FORMS)
    variants = Variants(plan.job)
    found = [_theory.spectral_radius(variants.scenario(point)) for point in plan.points]
    shape = [len(axis.values) for axis in plan.axes]
    axes = {axis.name: tuple(axis.values) for axis in plan.axes}
    return RadiusMap(axes, np.array(found).reshape(shape))
