"""``cohaptic fmu new`` and ``build`` of a model of one's own, anywhere."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from cosim.base.errors import InputError

if TYPE_CHECKING:
    from fmus.builder import Source

_VARIABLES = '''"""{title}: a mass on one axis under a force."""

from __future__ import annotations

from fmus.table import Model, ModelVariable

MODEL = Model(
    name="{name}",
    description="A mass on one axis under a force",
    sources=("model.c",),
    variables=(
        ModelVariable(
            name="force", description="Force on it", causality="input", unit="N", start=0.0
        ),
        ModelVariable(name="position", description="Position", causality="output", unit="m"),
        ModelVariable(
            name="mass",
            description="Mass",
            causality="parameter",
            unit="kg",
            start=0.5,
            minimum=0.0,
        ),
    ),
)
'''
_MODEL = """/* A mass on one axis under a force that is held over a step. */
#include "{name}_variables.h"

struct State {{
    double position; /* m */
    double velocity; /* m/s */
}};

const size_t model_state_size = sizeof(State);

const char *model_initialise(Variables *v, State *s, Report *r)
{{
    if (!(v->mass > 0.0))
        return "mass must be above 0 kg.";
    s->position = 0.0;
    s->velocity = 0.0;
    return NULL;
}}

void model_outputs(Variables *v, const State *s)
{{
    v->position = s->position;
}}

const char *model_step(Variables *v, State *s, double t, double h, Report *r)
{{
    double acceleration = v->force / v->mass;
    s->position += h * (s->velocity + 0.5 * h * acceleration);
    s->velocity += h * acceleration;
    return NULL;
}}
"""
_README = """# {name}

A mass m under a force F that is held over a step h, exactly:

    x' = x + h v + h²/2 F/m,    v' = v + h F/m.

`cohaptic fmu build {folder}` makes the archives {name}.fmi2.fmu, {name}.fmi3.fmu (scalars) and
{name}.fmi3-arrays.fmu.
"""


def write_new(folder: Path) -> list[Path]:
    """The three files of a model that works, to be changed.

    Raises:
        InputError: the name is none for C, or the folder has files.
    """
    name = folder.name
    if re.fullmatch(r"[a-z][a-z0-9_]*", name) is None:
        raise InputError(
            f"'{name}' cannot name a model: small letters, digits and underlines, a letter first."
        )
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(f"{folder} is there and not empty.")
    contents = {
        "variables.py": _VARIABLES.format(name=name, title=name),
        "model.c": _MODEL.format(name=name),
        "README.md": _README.format(name=name, folder=folder),
    }
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for file, text in contents.items():
            (folder / file).write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error.strerror}.") from None
    return [folder / file for file in contents]


def source_in(folder: Path) -> Source:
    """The model whose ``variables.py`` is in a folder.

    Raises:
        InputError: there is none, or it is no description of a model.
    """
    from fmus.builder import Source
    from fmus.table import Model

    file = folder / "variables.py"
    if not file.is_file():
        raise InputError(f"{folder} has no variables.py, so it holds no model of an FMU.")
    name = f"_cohaptic_model_{folder.resolve().name}"
    spec = importlib.util.spec_from_file_location(name, file)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:  # whatever the user's file raises
        raise InputError(f"{file} cannot be read: {type(error).__name__}: {error}") from None
    model = getattr(module, "MODEL", None)
    if not isinstance(model, Model):
        raise InputError(f"{file} has no MODEL, a fmus.table.Model.")
    return Source(model, folder.resolve())
