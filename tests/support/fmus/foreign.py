"""FMUs as others make them: a C snippet and the XML of some variables become an archive.

``native/foreign.c`` stores values by reference (up to 64) and calls the snippet's ``HOOK`` at every
FMI function. A variable is one XML element of the version's own form: in FMI 3
``<Float64 name="x" valueReference="1" causality="input" start="0"/>``, in FMI 2 a
``<ScalarVariable>``; :func:`scalar` writes either.
"""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path

from cosim.master.fmu.binding import platform_folder
from fmus import compiler
from fmus.cache import cache_directory
from fmus.compiler import host_platform
from tests.support.scratch import scratch_folder

SOURCE = Path(__file__).parent / "native" / "foreign.c"
FMI2_TYPES = {"Float64": "Real", "Int32": "Integer"}


def scalar(
    version: int, name: str, reference: int, kind: str = "Float64", inside: str = "", **more: str
) -> str:
    """One variable; ``more`` are attributes (``causality``, ``start``, ``unit`` …)."""
    if not kind.startswith("Float") and more.get("causality") in {"input", "output", "local"}:
        more = {"variability": "discrete", **more}
    if version == 3:
        return (
            f'<{kind} name="{name}" valueReference="{reference}" {_attributes(more)}>{inside}'
            f"</{kind}>"
        )
    outer = {key: more[key] for key in ("causality", "variability", "initial") if key in more}
    inner = {key: value for key, value in more.items() if key not in outer}
    return (
        f'<ScalarVariable name="{name}" valueReference="{reference}" {_attributes(outer)}>'
        f"<{FMI2_TYPES.get(kind, kind)} {_attributes(inner)}/>{inside}</ScalarVariable>"
    )


def foreign_fmu(
    folder: Path,
    version: int,
    variables: str,
    *,
    snippet: str = "",
    structure: str = "",
    before: str = "",
    interface: Mapping[str, str] | None = None,
    name: str = "foreign",
    extra: Mapping[str, str] | None = None,
) -> Path:
    """An archive ``<name>.fmu`` in ``folder``.

    ``structure`` is what ModelStructure holds, ``before`` what stands before the variables (units,
    types, log categories); ``interface`` changes attributes of CoSimulation, ``extra`` adds files.
    """
    attributes = {"modelIdentifier": name, "canHandleVariableCommunicationStepSize": "true"}
    attributes |= dict(interface or {})
    if version == 3:
        variables += "\n" + scalar(3, "time", 63, causality="independent")
    token = {2: 'guid="{0}"', 3: 'instantiationToken="0"'}[version]
    description = (
        f'<?xml version="1.0" encoding="UTF-8"?>\n<fmiModelDescription fmiVersion="{version}.0" '
        f'modelName="{name}" {token}>\n<CoSimulation {_attributes(attributes)}/>\n{before}\n'
        f"<ModelVariables>\n{variables}\n</ModelVariables>\n"
        f"<ModelStructure>\n{structure}\n</ModelStructure>\n</fmiModelDescription>\n"
    )
    path = folder / f"{name}.fmu"
    library = f"binaries/{platform_folder(version)}/{name}{host_platform().suffix}"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.writestr(library, _library(snippet))
        for entry, text in (extra or {}).items():
            archive.writestr(entry, text)
    return path


@functools.cache
def _library(snippet: str) -> bytes:
    """Compiled with the pinned compiler; what it takes of the C library, the process has.

    Kept by the content of all that it is made of, for other processes and later runs.
    """
    state = hashlib.sha256(snippet.encode())
    for file in (SOURCE, Path(compiler.__file__)):
        state.update(file.read_bytes())
    kept = cache_directory() / "tests" / f"{state.hexdigest()}{host_platform().suffix}"
    if not kept.is_file():
        folder = scratch_folder("test")
        (folder / "snippet.h").write_text(snippet)
        library = folder / f"{state.hexdigest()[:12]}{host_platform().suffix}"
        compiler.compile_library(host_platform(), library, [SOURCE], include=[folder])
        kept.parent.mkdir(parents=True, exist_ok=True)
        whole = kept.with_name(f"{kept.name}.{os.getpid()}")
        shutil.copyfile(library, whole)
        whole.replace(kept)
    return kept.read_bytes()


def _attributes(values: Mapping[str, str]) -> str:
    return " ".join(f'{key}="{value}"' for key, value in values.items())
