"""From a model's folder to its FMUs: find the models, generate their C, compile, pack.

What was built lies in ``fmus/_built`` with a note of the sources it was built from. Nothing is
built twice from the same sources, and what is older than its sources is not used.
"""

from __future__ import annotations

import hashlib
import importlib
import json
import os
import tempfile
import uuid
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cosim.base import meaning
from cosim.base.quantities import units
from fmus.archive import FLAVOURS, fmu_bytes, licence_files
from fmus.cache import cache_directory
from fmus.compiler import (
    PLATFORMS,
    BuildError,
    Platform,
    compile_library,
    host_platform,
)
from fmus.header import description_source, variables_header
from fmus.layout import SlotLayout
from fmus.names import model_names
from fmus.state import STATE_FILE, offsets_source, state_table
from fmus.symbols import fmi_functions, problems_of
from fmus.table import Model

FOLDER = Path(__file__).resolve().parent
"""The folder of the models: ``fmus/`` itself."""

BUILT = FOLDER / "_built"
"""Where what was built lies."""

GENERATED = cache_directory() / "generated" / hashlib.sha256(str(FOLDER).encode()).hexdigest()[:12]
"""Generated C: outside the checkout, where it would count as a changed source, and in one place for
all models, because the compiler's cache looks at the include path too."""

_SUPPORT = ("report.c", "number.c", "table_file.c", "platform.c")
_GLUE = ("instance.c", "values.c", "snapshot.c", "fmi2.c", "fmi3.c")
_GENERATORS = (
    "archive",
    "compiler",
    "description",
    "description2",
    "description3",
    "header",
    "state",
)
_INCLUDE = (
    FOLDER / "fmi",
    FOLDER / "fmi" / "headers",
    FOLDER / "fmi" / "freestanding",
    FOLDER / "libm",
    FOLDER / "libm" / "musl",
    *sorted(path.parent for path in (FOLDER / "shared").glob("*/__init__.py")),
    GENERATED,
)


@dataclass(frozen=True, slots=True)
class Source:
    """A model's description and the folder that its C files are in."""

    model: Model
    folder: Path


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


def source_of(name: str) -> Source:
    """A model in ``fmus/`` by its name."""
    return Source(load_model(name), FOLDER / name)


def model_files(source: Source) -> list[Path]:
    """The model's own C files: each beside its description or in a room of ``fmus/shared``."""
    found: list[Path] = []
    for name in source.model.sources:
        existing = [*source.folder.glob(name), *(FOLDER / "shared").glob(f"*/{name}")]
        if not existing:
            raise BuildError(
                f"Model {source.model.name} names a source '{name}', which is missing."
            )
        found.append(existing[0])
    return found


def source_digest(source: Source) -> str:
    """A SHA-256 of everything that the model's FMUs are made of."""
    own = [*model_files(source), *source.folder.glob("*.h"), source.folder / "variables.py"]
    if any(path.is_relative_to(FOLDER / "shared") for path in own):
        own += [*(FOLDER / "shared").glob("*/*.h"), *(FOLDER / "shared").glob("*/*.py")]
    digest = hashlib.sha256(_common_digest())
    digest.update(variables_header(source.model).encode())
    for path in sorted(own):
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    return digest.hexdigest()


def build_fmus(
    source: Source,
    *,
    platforms: Sequence[Platform] = PLATFORMS,
    output: Path = BUILT,
    force: bool = False,
) -> bool:
    """Build the three FMUs of one model where they are missing or older than their sources.

    Writes ``<model>.<flavour>.fmu`` and ``<model>.json`` into ``output``; each appears whole or
    not at all. Returns whether anything was built.

    Raises:
        BuildError: the model's table or its C is wrong.
    """
    model = source.model
    digest = source_digest(source)
    names = [platform.name for platform in platforms]
    note = {"digest": digest, "platforms": names}
    if not force and read_note(model.name, output) == note and _is_complete(model.name, output):
        return False
    output.mkdir(parents=True, exist_ok=True)
    token = f"{{{uuid.UUID(digest[:32])}}}"
    with tempfile.TemporaryDirectory(dir=output) as scratch_name:
        scratch = Path(scratch_name)
        _generate(f"{model.name}_variables.h", variables_header(model))
        description = _generate(
            f"{model.name}_description.c", description_source(model, token=token, digest=digest)
        )
        files = [*model_files(source), description, *_glue_files(), *support_files()]

        def compile_for(platform: Platform) -> bytes:
            path = scratch / platform.name / f"{model.name}{platform.suffix}"
            compile_library(platform, path, files, include=_INCLUDE)
            image = path.read_bytes()
            if problems := problems_of(image, platform.name, _fmi_functions()):
                raise BuildError(f"{path.name} for {platform.name}: {'; '.join(problems)}.")
            return image

        with ThreadPoolExecutor(os.cpu_count() or 1) as pool:
            libraries = dict(zip(names, pool.map(compile_for, platforms), strict=True))
        further = {
            f"documentation/licenses/{name}": text for name, text in licence_files(FOLDER).items()
        }
        if model.state:
            further[STATE_FILE] = state_table(
                build_development(model, folder=source.folder),
                model.state,
                slots=SlotLayout(model).slots,
                digest=digest,
                linear=model.linear,
            )
        for flavour in FLAVOURS:
            path = scratch / f"{model.name}.{flavour}.fmu"
            path.write_bytes(fmu_bytes(model, flavour, libraries, token=token, further=further))
        (scratch / f"{model.name}.json").write_text(json.dumps(note))
        for path in [*scratch.glob("*.fmu"), scratch / f"{model.name}.json"]:
            path.replace(output / path.name)
    return True


def build_all(names: Iterable[str] | None = None, *, force: bool = False) -> list[str]:
    """Build what is missing or stale of the models (all of them unless named); what was built."""
    return [name for name in names or model_names() if build_fmus(source_of(name), force=force)]


def read_note(name: str, folder: Path = BUILT) -> dict[str, object] | None:
    """What was noted when the model was built last: ``digest`` and ``platforms``."""
    path = folder / f"{name}.json"
    return json.loads(path.read_text()) if path.is_file() else None


def build_development(model: Model | str, *, folder: Path | None = None) -> Path:
    """Compile one model for this machine, without FMI, for ``fmus.development.Instance``.

    ``folder`` holds the C sources of a model that is not in ``fmus/``. The library is named after
    a hash of everything it is made of, so nothing is compiled twice.

    Raises:
        BuildError: the model's table or its C is wrong.
    """
    model = load_model(model) if isinstance(model, str) else model
    source = Source(model, folder or FOLDER / model.name)
    header = variables_header(model)
    files = [*model_files(source), FOLDER / "fmi" / "development.c", *support_files()]
    headers = [path for folder in (*_INCLUDE[:-1], source.folder) for path in folder.glob("*.h")]
    digest = hashlib.sha256(header.encode() + repr(model.state).encode())
    for path in [*files, *sorted(headers)]:
        digest.update(path.read_bytes())
    target = host_platform()
    place = BUILT / "development" / f"{model.name}-{digest.hexdigest()[:16]}{target.suffix}"
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        _generate(f"{model.name}_variables.h", header)
        with tempfile.TemporaryDirectory(dir=place.parent) as name:
            work = Path(name) / "work.c"
            work.write_text(
                f'#include "{model.name}_variables.h"\n'
                "const size_t model_work_bytes = MODEL_WORK_BYTES;\n",
                encoding="utf-8",
            )
            places = Path(name) / "offsets.c"
            text = offsets_source(model_files(source)[0], model.state) if model.state else ""
            places.write_text(text, encoding="utf-8")
            compile_library(
                target, Path(name) / place.name, [*files, work, places], include=_INCLUDE
            )
            (Path(name) / place.name).replace(place)
    return place


def support_files() -> list[Path]:
    """What every model is linked with: the report, the platform layer and the libm."""
    return [FOLDER / "fmi" / name for name in _SUPPORT] + sorted(
        (FOLDER / "libm" / "musl").glob("*.c")
    )


@cache
def _fmi_functions() -> frozenset[str]:
    return fmi_functions(FOLDER / "fmi" / "headers")


def _glue_files() -> list[Path]:
    return [FOLDER / "fmi" / name for name in _GLUE]


def _generate(name: str, text: str) -> Path:
    """Write a generated file, whole or not at all, unless it is there with the same text."""
    path = GENERATED / name
    if not path.is_file() or path.read_text() != text:
        GENERATED.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=GENERATED, delete=False) as file:
            file.write(text)
        Path(file.name).replace(path)
    return path


def _is_complete(name: str, folder: Path) -> bool:
    return all((folder / f"{name}.{flavour}.fmu").is_file() for flavour in FLAVOURS)


@cache
def _common_digest() -> bytes:
    """What all models share: the glue, the libm, the compiler flags and the generators."""
    files = [path for folder in _INCLUDE[:5] for path in folder.glob("*.h")]
    files += [*_glue_files(), *support_files()]
    files += [FOLDER / f"{name}.py" for name in (*_GENERATORS, "layout")]
    files += [Path(units.__file__), Path(meaning.__file__)]
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(f"{path.name}\0".encode() + path.read_bytes() + b"\0")
    return digest.digest()
