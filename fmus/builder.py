"""From a model's folder to its libraries: find the models, generate their C, compile."""

from __future__ import annotations

import hashlib
import importlib
import tempfile
from functools import cache
from pathlib import Path

from fmus.compiler import BuildError, compile_library, host_platform
from fmus.header import variables_header
from fmus.table import Model

FOLDER = Path(__file__).resolve().parent
"""The folder of the models: ``fmus/`` itself."""

BUILT = FOLDER / "_built"
"""Where what was built lies."""


@cache
def model_names() -> tuple[str, ...]:
    """The names of all models, in alphabetical order."""
    return tuple(sorted(path.parent.name for path in FOLDER.glob("*/variables.py")))


@cache
def load_model(name: str) -> Model:
    """The description of one model.

    Raises:
        BuildError: there is no such model, or its folder and name disagree.
    """
    if name not in model_names():
        raise BuildError(f"There is no model '{name}'; there are {', '.join(model_names())}.")
    model: Model = importlib.import_module(f"fmus.{name}.variables").MODEL
    if model.name != name:
        raise BuildError(f"The model in fmus/{name} calls itself '{model.name}'.")
    return model


def model_sources(model: Model, folder: Path | None = None) -> list[Path]:
    """The model's own C files: each beside its description or in ``fmus/shared``."""
    own = folder or FOLDER / model.name
    found: list[Path] = []
    for source in model.sources:
        candidates = (own / source, FOLDER / "shared" / source, FOLDER / source)
        existing = [path for path in candidates if path.is_file()]
        if not existing:
            raise BuildError(f"Model {model.name} names a source '{source}' that is not there.")
        found.append(existing[0])
    return found


def support_sources() -> list[Path]:
    """What every model is linked with: the report, the platform layer and the libm."""
    names = ("report.c", "number.c", "table_file.c", "platform.c")
    return [FOLDER / "fmi" / name for name in names] + sorted(
        (FOLDER / "libm" / "musl").glob("*.c")
    )


_LIBM = (FOLDER / "libm", FOLDER / "libm" / "musl")


def include_folders() -> list[Path]:
    """Where models and glue find their headers, the generated ones apart."""
    return [FOLDER / "fmi", FOLDER / "fmi" / "headers", *_LIBM, FOLDER / "shared"]


def build_development(model: Model | str, *, folder: Path | None = None) -> Path:
    """Compile one model for this machine, without FMI, for ``fmus.development.Instance``.

    ``folder`` holds the C sources of a model that is not in ``fmus/``. The library is named after
    a hash of everything it is made of, so nothing is compiled twice.

    Raises:
        BuildError: the model's table or its C is wrong.
    """
    if isinstance(model, str):
        model = load_model(model)
    header = variables_header(model)
    sources = [*model_sources(model, folder), FOLDER / "fmi" / "development.c", *support_sources()]
    include = [*include_folders(), *([folder] if folder else [])]
    digest = hashlib.sha256(header.encode())
    for path in [*sources, *(h for place in include for h in sorted(place.glob("*.h")))]:
        digest.update(path.read_bytes())
    target = host_platform()
    place = BUILT / "development" / f"{model.name}-{digest.hexdigest()[:16]}{target.suffix}"
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=place.parent) as name:
            scratch = Path(name)
            (scratch / f"{model.name}_variables.h").write_text(header)
            compile_library(target, scratch / place.name, sources, include=[*include, scratch])
            (scratch / place.name).replace(place)
    return place
