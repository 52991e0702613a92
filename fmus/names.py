"""What our models are called: a folder with a variable table is a model."""

from __future__ import annotations

from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean

FOLDER = Path(__file__).resolve().parent


def model_names() -> tuple[str, ...]:
    """The names of all models, in alphabetical order."""
    return tuple(sorted(path.parent.name for path in FOLDER.glob("*/variables.py")))


def check_name(name: str) -> None:
    """Refuse a name that none of our models has.

    Raises:
        InputError: with the name that may have been meant.
    """
    names = model_names()
    if name not in names:
        raise InputError(f"There is no model '{name}'.{did_you_mean(name, names)}")


def is_checkout() -> bool:
    """Whether this is a working copy, where sources change, and not an installed wheel."""
    return (FOLDER.parent / "hatch_build.py").is_file()
