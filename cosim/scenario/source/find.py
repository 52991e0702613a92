"""Where a scenario, an overlay or a preset is: a path first, then a bundled name."""

from __future__ import annotations

from os import PathLike, fspath
from os.path import relpath
from pathlib import Path

from cosim.base.errors import InputError, Location
from cosim.base.suggest import did_you_mean


def bundled_folder() -> Path:
    """The folder of the scenarios that come with cohaptic, in a checkout and in a wheel."""
    root = Path(__file__).resolve().parents[3]
    is_checkout = (root / "hatch_build.py").is_file()
    folder = root / "scenarios" if is_checkout else root / "cohaptic" / "_scenarios"
    if not folder.is_dir():
        raise InputError("the bundled scenarios are missing; install cohaptic again.")
    return folder


def bundled_names() -> list[str]:
    """The names of all bundled scenarios, overlays and presets, such as ``thesis/figure_8_1``."""
    folder = bundled_folder()
    found = (file.relative_to(folder).with_suffix("") for file in folder.rglob("*.yaml"))
    return sorted(file.as_posix() for file in found)


def find_file(
    name: str | PathLike[str], *, beside: Path | None = None, location: Location | None = None
) -> Path:
    """The file that ``name`` means.

    ``beside`` is the folder that relative paths start from (the working folder without it).
    A bundled name may be written with or without ``scenarios/`` and ``.yaml``; a preset also
    without ``presets/``.

    Raises:
        InputError: nothing of that name, or a folder.
    """
    text = fspath(name)
    try:
        path = (beside or Path()) / Path(text).expanduser()
        is_file, is_folder = path.is_file(), path.is_dir()
    except (OSError, ValueError, RuntimeError):
        raise InputError(f"'{text}' cannot be the name of a file.", location) from None
    if is_file:
        return path
    if is_folder:
        raise InputError(f"{text} is a folder, not a scenario file.", location)
    bundled = text.replace("\\", "/").removeprefix("scenarios/").removesuffix(".yaml")
    known = bundled_names()
    for candidate in (bundled, f"presets/{bundled}"):
        if candidate in known:
            return bundled_folder() / f"{candidate}.yaml"
    wanted = [bundled, f"presets/{bundled}"]
    close = next(filter(None, (did_you_mean(word, known, listed=0) for word in wanted)), "")
    raise InputError(
        f"there is no file {text} and no bundled scenario of that name.{close}", location
    )


def shown_name(path: Path) -> str:
    """How a file is named in messages: relative to the working folder where it lies inside."""
    absolute = path.resolve()
    inside = absolute.is_relative_to(Path.cwd().resolve())
    return relpath(absolute) if inside else str(absolute)
