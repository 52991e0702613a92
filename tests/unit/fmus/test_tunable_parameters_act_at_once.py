"""A tunable parameter that is set between two steps acts as if it had been so from the start."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.support.fmus import fmu_support as support

FLAVOURS = ("fmi2", "fmi3", "fmi3-arrays")
STEPS = 60


def tunable(name: str) -> list[str]:
    with support.Fmu(name, "fmi3-arrays") as fmu:
        return [n for n, v in fmu.variables.items() if v.variability == "tunable"]


TUNABLE = [(name, variable) for name in support.MODELS for variable in tunable(name)]


def changed(fmu: support.Fmu, variable: str) -> Any:
    described = fmu.variables[variable]
    start = fmu.get(variable)
    if described.type in {"Enumeration"}:
        return 0 if start else 1
    values = start if isinstance(start, list) else [start]
    new = [1.5 * value + 0.75 for value in values]
    return new if isinstance(start, list) else new[0]


def disturb(fmu: support.Fmu, random: np.random.Generator) -> None:
    """A little of everything on the inputs, so that what is tuned is felt."""
    for name in fmu.names("input"):
        if fmu.kind(name) not in {"Real", "Float64"}:
            continue
        values = random.normal(scale=0.02, size=fmu.shape(name)).tolist()
        fmu.set(name, values)


def bits(name: str, flavour: str, variable: str, *, tuned_late: bool) -> bytes:
    random = np.random.default_rng(7)
    found = b""
    with support.Fmu(name, flavour) as fmu:
        value = changed(fmu, variable)
        if not tuned_late:
            fmu.set(variable, value)
        fmu.start()
        if tuned_late:
            fmu.bits()  # what was worked out before is not used again
            fmu.set(variable, value)
        for _ in range(STEPS):
            disturb(fmu, random)
            found += fmu.bits()
            fmu.step(support.step_of(name))
    return found


@pytest.mark.parametrize(("name", "variable"), TUNABLE)
def test_set_before_the_first_step_is_set_before_the_start(name: str, variable: str) -> None:
    late = bits(name, "fmi3-arrays", variable, tuned_late=True)
    assert late == bits(name, "fmi3-arrays", variable, tuned_late=False)


def test_there_is_what_the_documentation_names() -> None:
    known = {variable for _, variable in TUNABLE}
    assert {"stiffness", "damping", "compensation", "compensation.x", "coupling_stiffness"} <= known
    assert {"local_normal_stiffness", "remote_tangential_damping", "amplitude", "offset"} <= known


@pytest.mark.parametrize("flavour", FLAVOURS)
def test_limits_hold_and_a_refused_set_changes_nothing(flavour: str) -> None:
    with support.Fmu("virtual_coupler", flavour) as fmu:
        fmu.set("stiffness", 100.0)
        fmu.start()
        fmu.set("position_a", 0.5)
        for value in (-1.0, float("nan"), float("inf")):
            with pytest.raises(support.Refused):
                fmu.set("stiffness", value)
        assert fmu.get("force") == 50.0
        fmu.set("stiffness", 300.0)
        assert fmu.get("force") == 150.0
