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
    check_name(name)
    path = FOLDER / "_built" / f"{name}.{flavour}.fmu"
    if not path.is_file():
        _check_flavour(flavour)
    if is_checkout():
        from fmus.fresh import refuse_stale

        refuse_stale(name, path)
    elif not path.is_file():
        from cosim.base.errors import InputError

        raise InputError(f"The FMU {path} is missing; reinstall cohaptic.")
    return path


def _check_flavour(flavour: str) -> None:
    from cosim.base.errors import InputError
    from fmus.archive import FLAVOURS

    if flavour not in FLAVOURS:
        raise InputError(f"There is no FMU flavour '{flavour}'; use one of {', '.join(FLAVOURS)}.")
