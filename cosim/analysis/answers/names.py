"""The thesis's names of a single-axis scenario's parameters, and the paths they stand for."""

from __future__ import annotations

from cosim.analysis.single_axis import ScenarioLoop, paths_of_leaves, read_single_axis
from cosim.base.errors import InputError
from cosim.scenario import Scenario
from cosim.theory.models.parameters import Parameters


def names_of(scenario: Scenario) -> dict[str, tuple[str, ...]]:
    """Each name with the scenario's paths that it sets; empty for what is no single-axis loop."""
    loop = closed_form_of(scenario)
    if loop is None:
        return {}
    leaves = paths_of_leaves(scenario)
    parameters = Parameters(loop.architecture, {}, loop.values, loop.users)
    found: dict[str, tuple[str, ...]] = {}
    for leaf, names in parameters.leaves.items():
        for name in names:
            found[name] = (*found.get(name, ()), *leaves.get(leaf, ()))
    # One of a pair stands for both (k_12 for k_21) except where it is a leaf of its own.
    return {name: tuple(dict.fromkeys(paths)) for name, paths in found.items() if paths}


def closed_form_of(scenario: Scenario) -> ScenarioLoop | None:
    """The loop of chapters 3 to 6 that a single-axis scenario is; None where it is none."""
    try:
        return read_single_axis(scenario)
    except InputError:
        return None
