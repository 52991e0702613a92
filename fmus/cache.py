"""Where compiled objects and unpacked FMUs are kept between runs: the user's cache directory."""

from __future__ import annotations

import os
import sys
import tempfile
from functools import cache
from pathlib import Path

from cosim.base.errors import CohapticError

VARIABLE = "COHAPTIC_CACHE_DIR"


class CacheError(CohapticError):
    """The folder chosen for caches cannot be used; no part of a scenario is at fault."""

    exit_status = 2


def cache_directory() -> Path:
    """The folder of ``COHAPTIC_CACHE_DIR``, else ``cohaptic`` in the system's place for caches.

    Where that cannot be written, a folder of the user's own among the temporary files, with a
    warning on stderr.

    Raises:
        CacheError: ``COHAPTIC_CACHE_DIR`` is no absolute path, or cannot be written.
    """
    chosen = os.environ.get(VARIABLE)
    if chosen is None:
        return _default(os.environ.get("HOME"), os.environ.get("XDG_CACHE_HOME"))
    folder = Path(chosen)
    if not folder.is_absolute():
        raise CacheError(
            f"{VARIABLE} is '{chosen}'; it has to be the absolute path of a folder for caches, or "
            "not be set."
        )
    reason = _refused(folder)
    if reason:
        raise CacheError(f"{VARIABLE} is '{chosen}', which cannot be written: {reason}.")
    return folder


@cache
def _default(_home: str | None, _xdg: str | None) -> Path:
    """The default for one environment; decided, and warned of, once."""
    try:
        folder = _usual_place() / "cohaptic"
        reason = _refused(folder)
    except RuntimeError:
        folder, reason = Path("~"), "there is no home folder"
    if not reason:
        return folder
    own = Path(tempfile.gettempdir()) / f"cohaptic-{_user()}"
    if _refused(own) or _belongs_to_another(own):
        own = Path(tempfile.mkdtemp(prefix="cohaptic-"))
    sys.stderr.write(
        f"warning: {folder} cannot be written ({reason}); caches go to {own}. Set {VARIABLE} to "
        "a folder that lasts.\n"
    )
    return own


def _usual_place() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    given = Path(os.environ.get("XDG_CACHE_HOME") or "")
    return given if given.is_absolute() else Path.home() / ".cache"


def _refused(folder: Path) -> str:
    """Why nothing can be written into ``folder``, which is made; empty if it can."""
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        with tempfile.TemporaryFile(dir=folder):
            return ""
    except OSError as error:
        return (error.strerror or str(error)).lower()


def _belongs_to_another(folder: Path) -> bool:
    """Whether somebody else made it: code from there is not to be run."""
    return hasattr(os, "getuid") and folder.stat().st_uid != os.getuid()


def _user() -> str:
    return str(os.getuid()) if hasattr(os, "getuid") else "user"
