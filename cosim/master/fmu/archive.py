"""Opening an FMU's zip safely: once per content, into the user's cache, never outside of it."""

from __future__ import annotations

import hashlib
import shutil
import stat
import tempfile
import zipfile
import zlib
from functools import lru_cache
from pathlib import Path, PurePosixPath

from cosim.base.errors import InputError

_DAMAGE = (zipfile.BadZipFile, zlib.error, EOFError, ValueError, NotImplementedError)

MAX_UNPACKED = 2 << 30
"""Largest archive that is unpacked (bytes)."""


def sha256_of(path: Path) -> str:
    """SHA-256 (hex) of a file, read again where its time or size is another.

    Raises:
        InputError: it cannot be read.
    """
    try:
        stat = path.stat()
        return _sha256(path, (stat.st_ino, stat.st_size, stat.st_mtime_ns))
    except FileNotFoundError:
        raise InputError(f"there is no FMU at {path}") from None
    except OSError as error:
        raise InputError(f"the FMU {path} cannot be read: {error.strerror}") from None


@lru_cache(maxsize=1024)
def _sha256(path: Path, _mark: tuple[int, ...]) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def unpack(path: Path, digest: str) -> Path:
    """The folder of an unpacked FMU; unpacked before if its content was met before.

    ``digest`` is the file's SHA-256 (hex).

    Raises:
        InputError: not a zip, damaged, too large, or an entry would be written outside its folder.
    """
    from fmus.cache import cache_directory

    folder = cache_directory() / "fmus" / digest
    if folder.is_dir():
        return folder
    with _open(path) as archive:
        _check_entries(path, archive)
        folder.parent.mkdir(parents=True, exist_ok=True)
        scratch = Path(tempfile.mkdtemp(prefix="unpacking-", dir=folder.parent))
        try:
            archive.extractall(scratch)
            scratch.chmod(0o755)
            _move(scratch, folder)
        except _DAMAGE as error:
            raise InputError(f"the FMU {path} is a damaged zip archive: {error}") from None
        except OSError as error:
            raise InputError(
                f"the FMU {path} could not be unpacked into {folder.parent}: {error.strerror}"
            ) from None
        finally:
            shutil.rmtree(scratch, ignore_errors=True)
    return folder


def _open(path: Path) -> zipfile.ZipFile:
    try:
        return zipfile.ZipFile(path)
    except (zipfile.BadZipFile, EOFError, ValueError):
        raise InputError(
            f"{path} is not a readable FMU: it is not a zip archive, or a damaged one"
        ) from None
    except OSError as error:
        raise InputError(f"the FMU {path} cannot be read: {error.strerror}") from None


def _check_entries(path: Path, archive: zipfile.ZipFile) -> None:
    total = 0
    for entry in archive.infolist():
        total += entry.file_size
        name = entry.filename.replace("\\", "/")
        place = PurePosixPath(name)
        if place.is_absolute() or ".." in place.parts or ":" in name.split("/")[0]:
            raise InputError(
                f"the FMU {path} has an entry '{entry.filename}' that would be written outside its "
                "folder; it is refused"
            )
        if stat.S_ISLNK(entry.external_attr >> 16):
            raise InputError(f"the FMU {path} has a link '{entry.filename}'; it is refused")
    if total > MAX_UNPACKED:
        raise InputError(f"the FMU {path} unpacks to {total} bytes, more than {MAX_UNPACKED}")


def _move(scratch: Path, folder: Path) -> None:
    try:
        scratch.rename(folder)
    except OSError:
        if not folder.is_dir():  # otherwise another process was first
            raise
