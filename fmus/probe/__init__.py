"""FMUs for tests only, not part of the wheel: they report, or they misbehave on purpose.

``probe_tick`` reports the tick of what it reads; ``probe_types`` has every type of variable;
``probe_substeps`` discards steps that are too long; ``probe_fixed_step`` refuses to change its
step; ``probe_failure`` fails at a chosen tick in a chosen way.
"""

from __future__ import annotations

import importlib
from pathlib import Path

from fmus.archive import FLAVOURS
from fmus.builder import BUILT, Source, build_fmus
from fmus.compiler import host_platform

_FOLDER = Path(__file__).resolve().parent


def probe_names() -> tuple[str, ...]:
    """The names of all probes, in alphabetical order."""
    return tuple(sorted(f"probe_{path.parent.name}" for path in _FOLDER.glob("*/variables.py")))


def source_of(name: str) -> Source:
    """The description and the folder of a probe."""
    short = name.removeprefix("probe_")
    model = importlib.import_module(f"fmus.probe.{short}.variables").MODEL
    return Source(model, _FOLDER / short)


def find(name: str, flavour: str = "fmi3") -> Path:
    """The FMU of a probe for this machine; compiled now if it is missing or stale.

    Raises:
        BuildError: it cannot be compiled.
    """
    if flavour not in FLAVOURS:
        raise ValueError(f"there is no FMU flavour '{flavour}'")
    output = BUILT / "probe"
    build_fmus(source_of(name), platforms=[host_platform()], output=output)
    return output / f"{name}.{flavour}.fmu"
