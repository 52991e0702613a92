"""Opening an FMU's zip safely: once per content, into the user's cache, never outside of it."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import stat
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Generator, Mapping
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path, PurePosixPath
from typing import Any, cast

from cosim.base.errors import InputError

_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError)

FOLDER, NOTE = "fmu", "files.json"
"""An FMU, and what it was unpacked to: as text, which every version of Python reads."""
MAX_UNPACKED = 2 << 30
"""Largest archive that is unpacked (bytes)."""
_DEEPEST = 100
"""Folders in each other, of an entry."""
_ENCRYPTED = 1
"""A bit of an entry's flags."""


def sha256_of(path: Path) -> str:
    """SHA-256 (hex) of a file, read again where its time or size is another; or of a folder.

    Raises:
        InputError: it cannot be read.
    """
    try:
        if path.is_dir():
            return _digest_of(path)
        stat = path.stat()
        return _sha256(path, (stat.st_ino, stat.st_size, stat.st_mtime_ns))
    except FileNotFoundError:
        raise InputError(f"there is no FMU at {path}") from None
    except OSError as error:
        raise InputError(f"the FMU {path} cannot be read: {error.strerror}") from None


def _digest_of(folder: Path) -> str:
    """Of all files by their names in the folder."""
    digest = hashlib.sha256()
    for file in sorted(at for at in folder.rglob("*") if at.is_file()):
        name = file.relative_to(folder).as_posix()
        digest.update(os.fsencode(name) + f"\0{sha256_of(file)}\0".encode())
    return digest.hexdigest()


@lru_cache(maxsize=1024)
def _sha256(path: Path, _mark: tuple[int, ...]) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def unpack(path: Path, digest: str) -> Path:
    """The folder of an unpacked FMU; unpacked before if its content was met before.

    ``digest`` is the file's SHA-256 (hex). A folder in which a file was changed, added or lost
    since (an FMU may write into its own resources) is unpacked anew.

    Raises:
        InputError: not a zip, damaged, too large, or an entry would be written outside its folder.
    """
    from fmus.cache import cache_directory

    home = cache_directory() / "unpacked-fmus" / digest
    if not _is_whole(home):
        home.parent.mkdir(parents=True, exist_ok=True)
        with _alone(home.with_name(f"{digest}.lock")):
            if not _is_whole(home):  # otherwise another process was first
                _remove(home)
                _fill(home, path)
    return home / FOLDER


def _fill(home: Path, path: Path) -> None:
    scratch = Path(tempfile.mkdtemp(prefix="unpacking-", dir=home.parent))
    try:
        (_copy if path.is_dir() else _extract)(path, scratch / FOLDER)
        scratch.chmod(0o755)
        # Both at once: others would take a folder without its note for one that was changed.
        _keep(scratch / NOTE, _state_of(scratch / FOLDER))
        _move(scratch, home)
    except (OSError, shutil.Error) as error:
        raise InputError(
            f"{path} could not be unpacked into {home.parent}: {_why(error)}"
        ) from None
    finally:
        shutil.rmtree(scratch, ignore_errors=True)


def _why(error: OSError) -> str:
    """What stood in the way; copying a folder goes on behind the first and tells them all."""
    if isinstance(error, shutil.Error) and error.args and isinstance(error.args[0], list):
        (place, _, said), *others = cast("list[tuple[str, str, str]]", error.args[0])
        more = f" (and {len(others)} more)" if others else ""
        return f"{_brief(place)}: {_brief(said)}{more}"
    return error.strerror or str(error)


def _brief(text: str) -> str:
    return text if len(text) <= 200 else f"{text[:100]} … {text[-80:]}"


def _keep(note: Path, state: Mapping[str, list[int]]) -> None:
    note.write_text(json.dumps(state), encoding="utf-8")


@contextmanager
def _alone(lock: Path) -> Generator[None]:
    """One process at a time judges what is there and unpacks: it takes away no other's work."""
    if sys.platform == "win32":
        yield
        return
    import fcntl

    with lock.open("ab") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _is_whole(home: Path) -> bool:
    """Whether the files are those that were unpacked."""
    try:
        kept: Any = json.loads((home / NOTE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False
    return kept == _state_of(home / FOLDER)


def _extract(path: Path, folder: Path) -> None:
    with _open(path) as archive:
        _check_entries(path, archive)
        try:
            for entry in archive.infolist():
                archive.extract(entry, folder)
        except _DAMAGE as error:
            raise InputError(f"{path} is a damaged zip archive: {error}") from None


def _copy(given: Path, folder: Path) -> None:
    """An FMU that is unpacked already: a copy, since it may write where it lies."""
    shutil.copytree(given, folder)


def _open(path: Path) -> zipfile.ZipFile:
    try:
        return zipfile.ZipFile(path)
    except (zipfile.BadZipFile, EOFError, ValueError):
        raise InputError(
            f"{path} cannot be read: it is not a zip archive, or a damaged one"
        ) from None
    except OSError as error:
        raise InputError(f"the FMU {path} cannot be read: {error.strerror}") from None


def _check_entries(path: Path, archive: zipfile.ZipFile) -> None:
    total = 0
    met: dict[str, int] = {}
    for entry in archive.infolist():
        total += entry.file_size
        # Some tools of Windows write backslashes, which are part of a name elsewhere.
        name = entry.filename = entry.filename.replace("\\", "/")
        place = PurePosixPath(name)
        if place.is_absolute() or ".." in place.parts or ":" in name.split("/")[0]:
            raise InputError(
                f"{path} has an entry '{entry.filename}' that would be written outside its "
                "folder; it is refused"
            )
        if entry.flag_bits & _ENCRYPTED:
            raise InputError(f"{path} is encrypted ('{name}'); unpack it with its password")
        if len(place.parts) > _DEEPEST:
            raise InputError(
                f"{path} has an entry {len(place.parts)} folders deep ('{_brief(name)}'); "
                "it is refused"
            )
        if met.setdefault(name, entry.CRC) != entry.CRC:
            raise InputError(
                f"{path} has two different entries '{name}'; it is refused, since nobody "
                "can say which one counts"
            )
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise InputError(f"{path} has a link '{entry.filename}'; it is refused")
    if total > MAX_UNPACKED:
        raise InputError(f"{path} unpacks to {total} bytes, more than {MAX_UNPACKED}")


def _state_of(folder: Path) -> dict[str, list[int]]:
    """Size (bytes) and time of change (ns) of every file, by its place in the folder."""
    found: dict[str, list[int]] = {}
    for at, _, names in os.walk(folder):
        for name in names:
            file = f"{at}{os.sep}{name}"
            try:
                stat = os.lstat(file)
            except FileNotFoundError:  # it is being taken away
                continue
            found[file.removeprefix(str(folder))] = [stat.st_size, stat.st_mtime_ns]
    return found


def _remove(folder: Path) -> None:
    """Out of the way at once: another process may be about to use the name."""
    grave = Path(tempfile.mkdtemp(prefix="changed-", dir=folder.parent))
    with suppress(OSError):
        folder.rename(grave / folder.name)
    shutil.rmtree(grave, ignore_errors=True)


def _move(scratch: Path, folder: Path) -> None:
    try:
        scratch.rename(folder)
    except OSError:
        if not folder.is_dir():  # otherwise another process was first
            raise
