"""FMUs as files: what is in one, without running it."""

from __future__ import annotations

from pathlib import Path

from cosim.base.errors import InputError
from cosim.base.suggest import did_you_mean
from cosim.master.fmu.description import FmuDescription
from cosim.master.fmu.reading import read_description

__all__ = ["FmuDescription", "bundled", "read"]


def bundled() -> list[str]:
    """The models that come with cohaptic, by name."""
    import fmus

    return sorted(fmus.model_names())


def read(path: str | Path, flavour: str = "fmi3") -> FmuDescription:
    """Variables, units, version and digest of an FMU: a file's, or a bundled model's by its name.

    Raises:
        InputError: there is none, or it is not an FMU that can be read.
    """
    import fmus

    if Path(path).is_file():
        return read_description(Path(path))
    if str(path) not in fmus.model_names():
        hint = did_you_mean(str(path), fmus.model_names())
        raise InputError(f"{path}: there is no such file, and no bundled model.{hint}")
    return read_description(fmus.find(str(path), flavour))
