"""A value reference in any modelDescription is where the C compiler puts the variable."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import pytest

from fmus.builder import FOLDER
from fmus.compiler import compile_library, host_platform
from fmus.header import variables_header
from fmus.table import Group, Model, ModelVariable
from tests.support.fmus import fmu_support as support

INCLUDE = [FOLDER / "fmi", FOLDER / "libm"]


def repeated_groups(members: tuple[ModelVariable | Group, ...]) -> set[str]:
    found: set[str] = set()
    for member in members:
        if isinstance(member, Group):
            found |= repeated_groups(member.members)
            if member.count is not None:
                found.add(member.name)
    return found


def c_expression(name: str, groups: set[str]) -> str:
    """``finger_2.position[1]`` is ``finger[1].position[0]`` in C."""
    parts = []
    for part in name.split("."):
        match = re.fullmatch(r"(\w+)_(\d+)", part)
        if match and match[1] in groups:
            parts.append(f"{match[1]}[{int(match[2]) - 1}]")
        else:
            parts.append(re.sub(r"\[(\d+)\]", lambda m: f"[{int(m[1]) - 1}]", part))
    return ".".join(parts)


def compile_claims(model: Model, claims: list[str]) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / f"{model.name}_variables.h").write_text(variables_header(model))
        lines = [f'#include "{model.name}_variables.h"', *claims, "int unused;"]
        (folder / "claims.c").write_text("\n".join(lines))
        compile_library(
            host_platform(),
            folder / f"claims{host_platform().suffix}",
            [folder / "claims.c"],
            include=[*INCLUDE, folder],
        )


@pytest.mark.parametrize("name", [*support.MODELS, *support.PROBES])
def test_value_reference_is_offset(name: str) -> None:
    model = support.source(name).model
    groups = repeated_groups(model.variables)
    claims: list[str] = []
    for flavour in ("fmi2", "fmi3", "fmi3-arrays"):
        _, description = support.unpacked(name, flavour)
        claims += [
            f"_Static_assert(offsetof(struct Variables, {c_expression(v.name, groups)})"
            f' == {8 * v.valueReference}, "{v.name}");'
            for v in description.modelVariables
            if v.name != "time"
        ]
        time = [v.valueReference for v in description.modelVariables if v.name == "time"]
        claims += [f'_Static_assert(sizeof(struct Variables) == {8 * t}, "size");' for t in time]
        assert bool(time) == (flavour != "fmi2")
    compile_claims(model, claims)


def test_a_wrong_claim_does_not_compile() -> None:
    from fmus.compiler import BuildError

    with pytest.raises(BuildError, match="mass"):
        compile_claims(
            support.source("hand").model,
            ['_Static_assert(offsetof(struct Variables, mass) == 0, "mass");'],
        )
