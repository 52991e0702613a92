"""Opening what is given: an SSP, the folder of an unpacked one, an SSD, an OSP system structure."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

from cosim.base.errors import InputError
from cosim.master.fmu.archive import sha256_of, unpack
from cosim.ssp.documents import SSD, namespace_of, read_valid, read_xml
from cosim.ssp.importing import to_scenario
from cosim.ssp.osp import OSP, read_osp
from cosim.ssp.structure import read_structure

ROOT = "SystemStructure.ssd"
OSP_FILE = "OspSystemStructure.xml"


def is_system(given: str | None) -> bool:
    """Whether what was given is a system structure rather than a scenario or an FMU."""
    if given is None:
        return False
    path = Path(given).expanduser()
    if path.is_dir():
        return (path / ROOT).is_file() or (path / OSP_FILE).is_file()
    return path.suffix.casefold() in {".ssp", ".ssd"} or path.name.endswith(OSP_FILE)


def read_system(
    path: Path, stop_time: Fraction | None, start_time: Fraction | None = None
) -> tuple[dict[str, Any], list[str]]:
    """The document of a scenario, and what is worth telling.

    The times (s) take the place of the system's.

    Raises:
        InputError: it cannot be read, or uses what cannot be used here.
    """
    file, notes = _file(path.expanduser().absolute()), list[str]()
    if namespace_of(root := read_xml(file)) == OSP:
        structure = read_osp(root, file, notes)
    else:
        root, broken = read_valid(file)
        if namespace_of(root) != SSD:
            raise InputError(f"{file} describes no system: its root is {root.tag}.")
        notes += broken
        structure = read_structure(root, file)
    return to_scenario(structure, stop_time, notes, start_time), notes


def _file(path: Path) -> Path:
    if path.is_dir():
        return next(path / name for name in (ROOT, OSP_FILE) if (path / name).is_file())
    if not path.is_file():
        raise InputError(f"there is no file {path}.")
    if path.suffix.casefold() != ".ssp":
        return path
    file = unpack(path, sha256_of(path)) / ROOT
    if not file.is_file():
        raise InputError(f"{path} has no {ROOT} at its top, so it is no SSP.")
    return file
