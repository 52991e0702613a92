"""The library of an FMU for this machine."""

from __future__ import annotations

from pathlib import Path

from cosim.base.errors import InputError
from cosim.master.fmu.binding import library_suffix, platform_folder
from cosim.master.fmu.description import FmuDescription


def find_binary(description: FmuDescription) -> Path:
    """The FMU's library for this machine.

    Raises:
        InputError: there is none; says for which platforms there is.
    """
    platform = platform_folder(description.version)
    binaries = description.folder / "binaries"
    path = binaries / platform / (description.model_identifier + library_suffix())
    if path.is_file():
        return path
    if path.is_dir():
        raise InputError(
            f"{path.relative_to(description.folder)} of the FMU {description.path} is "
            "a folder, not a library"
        )
    if (binaries / platform).is_dir():
        others = sorted(p.name for p in (binaries / platform).glob(f"*{library_suffix()}"))
        raise InputError(
            f"the library of the FMU {description.path} has to be called {path.name}, as its "
            f"modelIdentifier; in {platform} "
            + (f"there is {', '.join(others)}" if others else "there is no library at all")
        )
    there = sorted(p.name for p in binaries.iterdir() if p.is_dir()) if binaries.is_dir() else []
    raise InputError(
        f"the FMU {description.path} has no library for {platform}, this machine; it has "
        + (f"{', '.join(there)}" if there else "none at all (source code only?)")
    )
