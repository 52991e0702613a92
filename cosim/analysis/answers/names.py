"""The thesis's names of a single-axis scenario's parameters, and the paths they stand for."""

from __future__ import annotations

from collections.abc import Mapping

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


def overrides(scenario: Scenario, given: Mapping[str, float]) -> list[str]:
    """The overrides that give parameters by the thesis's names; of a pair one stands for both.

    Raises:
        InputError: the scenario has no such parameter.
    """
    loop = closed_form_of(scenario)
    if loop is None:
        raise InputError(
            f"{next(iter(given))} is a name of chapters 3 to 6, and the scenario is no loop of "
            "theirs: give a path, such as --set components.NAME.parameters.KEY=VALUE."
        )
    parameters = Parameters(loop.architecture, given, loop.values, loop.users)
    leaves = paths_of_leaves(scenario)
    found: list[str] = []
    for leaf in parameters.leaves:
        if parameters.source(leaf) not in parameters.given:
            continue
        if leaf not in leaves:
            raise InputError(f"The scenario has nothing that {leaf} could be.")
        found += [f"{path}={parameters[leaf]!r}" for path in leaves[leaf]]
    return found
