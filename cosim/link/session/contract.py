"""What two stations must agree on before they push on each other's hands, and how they differ."""

from __future__ import annotations

import hashlib
import json
import re
import zlib
from collections.abc import Mapping
from typing import Any, cast

from cosim.link.wire.packet import VERSION

LARGEST_TEXT = 4_000_000
"""Bytes of a contract as text; a peer that sends more is not read."""


class Contract:
    """Nested plain values, flattened to ``path -> text``; equal contracts have equal hashes."""

    def __init__(self, values: Mapping[str, Any]) -> None:
        flat: dict[str, str] = {"protocol": str(VERSION)}
        _flatten(values, "", flat)
        self.entries: Mapping[str, str] = dict(sorted(flat.items(), key=_natural))
        self._text = json.dumps(self.entries, separators=(",", ":"), ensure_ascii=False).encode()
        self.hash = hashlib.sha256(self._text).digest()
        """32 bytes."""

    def packed(self) -> bytes:
        """The whole contract, compressed, for a peer that wants to show the difference."""
        return zlib.compress(self._text, 9)

    @staticmethod
    def unpack(packed: bytes) -> dict[str, str]:
        """The entries of a peer's contract; empty where it makes no sense.

        It is only ever shown, never acted on.
        """
        try:
            text = zlib.decompressobj().decompress(packed, LARGEST_TEXT)
            loaded = json.loads(text)
        except (zlib.error, ValueError, RecursionError):
            return {}
        if not isinstance(loaded, dict):
            return {}
        entries = cast("dict[Any, Any]", loaded)
        return {str(key): str(value) for key, value in entries.items()}

    def difference(self, other: Mapping[str, str], own: str, peer: str) -> list[str]:
        """One sentence for each entry that differs, in the order of the paths."""
        lines: list[str] = []
        paths = dict.fromkeys((*self.entries, *other))
        for path, _ in sorted(paths.items(), key=_natural):
            mine, theirs = self.entries.get(path), other.get(path)
            if mine == theirs:
                continue
            if theirs is None:
                lines.append(f"{path}: {mine} at {own}, absent at {peer}")
            elif mine is None:
                lines.append(f"{_printable(path)}: absent at {own}, {_printable(theirs)} at {peer}")
            else:
                lines.append(f"{path}: {mine} at {own}, {_printable(theirs)} at {peer}")
        return lines


def _flatten(value: Any, path: str, into: dict[str, str]) -> None:
    if isinstance(value, Mapping):
        members = cast("Mapping[Any, Any]", value)
        for key, member in members.items():
            _flatten(member, f"{path}.{key}" if path else str(key), into)
    elif isinstance(value, list | tuple):
        items = cast("list[Any]", value)
        for number, item in enumerate(items, start=1):
            _flatten(item, f"{path}[{number}]", into)
    else:
        into[path] = _text(value)


def _text(value: Any) -> str:
    """One value: of numbers the shortest text that is exact, so that 1 and 1.0 are one."""
    if isinstance(value, bool):
        return str(value).lower()
    # An integer that no float64 holds is written out.
    if isinstance(value, float) or (isinstance(value, int) and abs(value) <= 1 << 53):
        return repr(float(value))
    return str(value)


def _natural(entry: tuple[str, object]) -> list[tuple[int, str]]:
    """Paths in the order of people: digits count as the number that they write."""
    parts = re.findall(r"[0-9]+|[^0-9]+", entry[0])
    # Of two numbers without leading zeros the longer one is larger; a peer may write any.
    digits = [(part.lstrip("0") if part[0] in "0123456789" else None, part) for part in parts]
    return [(-1, part) if plain is None else (len(plain), plain) for plain, part in digits]


def _printable(text: str) -> str:
    """A peer's text without control characters, so that it cannot write on a terminal."""
    return "".join(letter if letter.isprintable() else "?" for letter in text[:200])
