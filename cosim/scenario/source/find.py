"""Where a scenario, an overlay or a preset is: a path first, then a bundled name."""

from __future__ import annotations

import errno
import stat
from os import PathLike, fspath
from os.path import relpath
from pathlib import Path

from cosim.base.document.text_file import STANDARD_INPUT
from cosim.base.errors import InputError, Location
from cosim.base.suggest import nearest


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
    if text == "-" and beside is None:
        return Path(STANDARD_INPUT)
    path = (beside or Path()) / text
    try:
        path = (beside or Path()) / Path(text).expanduser()
        mode = path.stat().st_mode
    except (ValueError, RuntimeError):
        raise InputError(f"'{text}' cannot be the name of a file.", location) from None
    except OSError as error:
        if error.errno not in {errno.ENOENT, errno.ENOTDIR}:
            raise InputError(f"cannot read {text}: {_reason(error)}.", location) from None
        return _find_bundled(text, path, location)
    if stat.S_ISREG(mode) or stat.S_ISFIFO(mode):
        return path
    if stat.S_ISDIR(mode):
        raise InputError(f"{text} is a folder, not a scenario file.{_inside(path)}", location)
    raise InputError(f"{text} is a device or socket, not a scenario file.", location)


def folder_of(file: str) -> Path:
    """The folder that relative names in a file start from; a pipe's is the working folder."""
    path = Path(file).absolute()
    return Path.cwd() if path.is_fifo() or file == STANDARD_INPUT else path.parent


def folder_at(place: Location) -> Path:
    """The folder that a relative name written at ``place`` starts from."""
    return folder_of(place.file) if place.line else Path.cwd()


def _find_bundled(text: str, path: Path, location: Location | None) -> Path:
    if path.is_symlink():
        target = path.readlink()
        raise InputError(f"{text} is a link to {target}, which does not exist.", location)
    bundled = text.replace("\\", "/").removeprefix("scenarios/").removesuffix(".yaml")
    known = bundled_names()
    for candidate in (bundled, f"presets/{bundled}"):
        if candidate in known:
            return bundled_folder() / f"{candidate}.yaml"
    raise InputError(
        f"there is no file {text} and no bundled scenario of that name."
        f"{_nearest(bundled, path, known)}",
        location,
    )


def _nearest(bundled: str, path: Path, known: list[str]) -> str:
    """The file beside it or the bundled scenario that is meant, if one is nearly called so."""
    beside = path.parent.glob("*.y*ml") if path.parent.is_dir() else ()
    names = {file.stem: str(file) for file in beside} | {name: name for name in known}
    names |= {name.rpartition("/")[2]: name for name in known}
    wanted = bundled.rpartition("/")[2]
    near = nearest(bundled, names, 0.8) or nearest(wanted, names, 0.8)
    return f" Did you mean {names[near]}?" if near else ""


def _inside(folder: Path) -> str:
    """Which scenarios are in a folder that was given for one."""
    if (folder / "scenario.resolved.yaml").is_file():
        return f" It is the folder of a run; its scenario is {folder / 'scenario.resolved.yaml'}."
    found = sorted(file.name for file in folder.glob("*.yaml"))[:3]
    return f" In it is {folder / found[0]}." if found else ""


def _reason(error: OSError) -> str:
    if error.errno == errno.ELOOP:
        return "its links lead in a circle"
    return (error.strerror or str(error)).lower()


def shown_name(path: Path) -> str:
    """How a file is named in messages: relative to the working folder where it lies inside."""
    if str(path) == STANDARD_INPUT or path.is_fifo():
        return str(path)
    absolute = path.resolve()
    inside = absolute.is_relative_to(Path.cwd().resolve())
    return relpath(absolute) if inside else str(absolute)
