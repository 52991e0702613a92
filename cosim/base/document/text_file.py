"""The text of a file that a user names; what is no text is told for what it is."""

from __future__ import annotations

import sys
from pathlib import Path

from cosim.base.errors import InputError, Location

STANDARD_INPUT = "standard input"
"""How the scenario that ``-`` stands for is called in messages."""

_KINDS = (
    (b"\x89HDF", "a record (HDF5); the run's scenario is scenario.resolved.yaml beside it"),
    (b"\x7fELF", "a program or library"),
    (b"\x1f\x8b", "a compressed file; unpack it first"),
    (b"%PDF", "a PDF document"),
    (b"\x89PNG", "a picture"),
    (b"\xff\xfe", "text in UTF-16; save the file as UTF-8"),
    (b"\xfe\xff", "text in UTF-16; save the file as UTF-8"),
)


def read_text(path: Path, shown: str) -> str:
    """The file's text, without a byte-order mark; standard input where ``shown`` says so.

    Raises:
        InputError: it cannot be read, or is no UTF-8 text.
    """
    try:
        found = sys.stdin.buffer.read() if shown == STANDARD_INPUT else path.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read {shown}: {error.strerror or error}.") from None
    kind = _kind(found, path)
    if kind:
        raise InputError(f"this is {kind}.", Location(shown, 1, 1))
    try:
        return found.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"not UTF-8 text (byte {error.start}); save the file as UTF-8.", Location(shown, 1, 1)
        ) from None


def _kind(found: bytes, path: Path) -> str:
    """What a file that is no text is, and what to do instead; empty for text."""
    if found.startswith(b"PK\x03\x04"):
        if path.suffix.casefold() == ".fmu":
            return "an FMU, not a scenario; a scenario names it: '{fmu: FILE.fmu, rate: …}'"
        if path.suffix.casefold() == ".ssp":
            return "an SSP package, not a scenario, which is YAML text"
        return "a zip archive; a scenario is YAML text"
    known = next((kind for magic, kind in _KINDS if found.startswith(magic)), "")
    return known or ("a binary file; a scenario is YAML text" if b"\0" in found[:4096] else "")
