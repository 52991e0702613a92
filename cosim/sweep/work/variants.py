"""From the values of a point to a scenario: built anew only where the values are no plain ones.

A seed, and a number that a component's parameter gets, with or without a unit, change one member of
a scenario that was built before. Everything else (a delay, a duration, a rate, a list) goes the way
of ``--set``; what came of it is kept, so that a grid builds each of those values once.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from cosim.base.changed import changed as with_members
from cosim.base.document.node import Node
from cosim.scenario import Scenario
from cosim.scenario.load import Written
from cosim.sweep.job import Job, override
from cosim.sweep.planning.axis import Value, unit_of

KEPT = 512
"""Scenarios that are kept; each shares most of its parts with the others."""
_LARGEST_SEED = 2**63


class Variants:
    """The scenarios of a sweep's points."""

    def __init__(self, job: Job) -> None:
        self._job = job
        self._built: dict[tuple[str, ...], Scenario] = {}
        self._plain = [
            [place for place in axis.places if _is_plain(job.written.root, place)]
            for axis in job.axes
        ]

    def scenario(self, point: Sequence[Value]) -> Scenario:
        """The scenario of a point.

        Raises:
            InputError: a value cannot be used.
        """
        sets: list[str] = []
        plain: dict[str, Value] = {}
        for axis, places, value in zip(self._job.axes, self._plain, point, strict=True):
            for place in axis.places:
                if place in places and _fits(place, value):
                    plain[place] = value
                else:
                    sets.append(override(place, value))
        return _with(self._of(tuple(sets)), plain)

    def anew(self, point: Sequence[Value]) -> Scenario:
        """The same, with nothing kept."""
        return build(self._job.written, self._job.overrides(point))

    def _of(self, sets: tuple[str, ...]) -> Scenario:
        if sets not in self._built:
            if len(self._built) >= KEPT:
                self._built.clear()
            self._built[sets] = build(self._job.written, sets)
        return self._built[sets]


def build(written: Written, sets: Sequence[str]) -> Scenario:
    """A scenario with overrides, and numbers in place of every ``compensation: auto``.

    Raises:
        InputError: one or more problems, each with its place.
    """
    from cosim.analysis.compensation import tuned_scenario

    return tuned_scenario(written.changed(sets))


def _is_plain(root: Node, place: str) -> bool:
    """Whether a number at this place leaves everything else in the scenario as it is."""
    if place == "seed":
        return True
    keys = place.split(".", 3)
    if len(keys) != 4 or keys[0] != "components" or keys[2] != "parameters":
        return False
    _, name, _, parameter = keys
    part = root.find(("components", name))[0]
    node, depth = root.find(("components", name, "parameters", parameter))
    is_there = depth == 4 and _is_number(node.value)
    is_new = depth < 4 and parameter.isidentifier() and part.is_mapping
    return (is_there or is_new) and not _is_tuned(root)


def _is_tuned(root: Node) -> bool:
    """Whether ``compensation: auto`` stands anywhere: then every value may change it."""
    components = root.child("components")
    members = components.value if components is not None else {}
    if not isinstance(members, dict):
        return False
    found = (part.find(("parameters", "compensation")) for part in members.values())
    return any(depth == 2 and isinstance(node.value, str) for node, depth in found)


def _fits(place: str, value: Value) -> bool:
    if place == "seed":
        return type(value) is int and 0 <= value < _LARGEST_SEED
    return _is_number(value)


def _is_number(value: Any) -> bool:
    """Whether it is one, with a unit or without."""
    if isinstance(value, str):
        return bool(unit_of(value)) and not value.lstrip("+-").startswith(("0x", "0o"))
    return isinstance(value, int | float) and not isinstance(value, bool)


def _with(scenario: Scenario, plain: Mapping[str, Value]) -> Scenario:
    if not plain:
        return scenario
    changed: dict[str, dict[str, Any]] = {}
    seed = scenario.seed
    for place, value in plain.items():
        if place == "seed":
            seed = int(value)
            continue
        _, name, _, parameter = place.split(".", 3)
        changed.setdefault(name, {})[parameter] = value
    if not changed:
        return with_members(scenario, seed=seed)
    components = dict(scenario.components)
    for name, values in changed.items():
        part = components[name]
        components[name] = with_members(part, parameters={**part.parameters, **values})
    return with_members(scenario, seed=seed, components=components)
