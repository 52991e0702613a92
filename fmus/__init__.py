"""The models in plain C, and how they become FMUs."""

from __future__ import annotations

from pathlib import Path

from fmus.names import FOLDER, check_name, is_checkout, model_names

__all__ = ["check_name", "find", "is_checkout", "model_names"]


def find(name: str, flavour: str = "fmi3") -> Path:
    """The FMU of one of our models.

    ``flavour`` is ``fmi2``, ``fmi3`` (scalars) or ``fmi3-arrays``.

    Raises:
        InputError: there is no such model, or its FMU is missing or older than its sources.
    """
    from cosim.base.errors import InputError
    from fmus.archive import FLAVOURS

    if flavour not in FLAVOURS:
        raise InputError(f"There is no FMU flavour '{flavour}'; use one of {', '.join(FLAVOURS)}.")
    check_name(name)
    path = FOLDER / "_built" / f"{name}.{flavour}.fmu"
    if is_checkout():
        _refuse_stale(name, path)
    elif not path.is_file():
        raise InputError(f"The FMU {path} is missing; reinstall cohaptic.")
    return path


def _refuse_stale(name: str, path: Path) -> None:
    from cosim.base.errors import InputError
    from fmus.builder import read_note, source_digest, source_of

    remedy = f"build it with 'uv sync' or 'uv run cohaptic fmu build {name}'."
    note = read_note(name)
    if note is None or not path.is_file():
        raise InputError(f"The FMU of '{name}' has not been built; {remedy}")
    if note["digest"] != source_digest(source_of(name)):
        raise InputError(f"The FMU of '{name}' is older than its sources; {remedy}")
