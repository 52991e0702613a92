"""The models in plain C, and how they become FMUs."""

from __future__ import annotations

from pathlib import Path

_FOLDER = Path(__file__).resolve().parent


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
    path = _FOLDER / "_built" / f"{name}.{flavour}.fmu"
    if is_checkout():
        _refuse_stale(name, path)
    elif not path.is_file():
        raise InputError(f"The FMU {path} is missing; reinstall cohaptic.")
    return path


def model_names() -> tuple[str, ...]:
    """The names of all models, in alphabetical order."""
    return tuple(sorted(path.parent.name for path in _FOLDER.glob("*/variables.py")))


def check_name(name: str) -> None:
    """Refuse a name that none of our models has.

    Raises:
        InputError: with the name that may have been meant.
    """
    from cosim.base.errors import InputError
    from cosim.base.suggest import did_you_mean

    names = model_names()
    if name not in names:
        raise InputError(f"There is no model '{name}'.{did_you_mean(name, names)}")


def is_checkout() -> bool:
    """Whether this is a working copy, where sources change, and not an installed wheel."""
    return (_FOLDER.parent / "hatch_build.py").is_file()


def _refuse_stale(name: str, path: Path) -> None:
    from cosim.base.errors import InputError
    from fmus.builder import read_note, source_digest, source_of

    remedy = f"build it with 'uv sync' or 'uv run cohaptic fmu build {name}'."
    note = read_note(name)
    if note is None or not path.is_file():
        raise InputError(f"The FMU of '{name}' has not been built; {remedy}")
    if note["digest"] != source_digest(source_of(name)):
        raise InputError(f"The FMU of '{name}' is older than its sources; {remedy}")
