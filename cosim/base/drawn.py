"""Which recorded signals a scene names (``cosim.scene`` describes one, as JSON)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, cast


def signals_of(scene: Mapping[str, Any]) -> list[str]:
    """Every recorded signal that a scene names, once, in order."""
    return list(dict.fromkeys(_names(scene)))


def _names(entry: Any) -> Iterator[str]:
    if isinstance(entry, Mapping):
        for key, value in cast("Mapping[str, Any]", entry).items():
            if key in _SIGNAL_KEYS:
                yield from [value] if isinstance(value, str) else value or ()
            else:
                yield from _names(value)
    elif isinstance(entry, list):
        for each in cast("list[Any]", entry):
            yield from _names(each)


_SIGNAL_KEYS = frozenset(
    {
        *("pose", "nodes", "penetration", "position", "force", "state", "normal_force"),
        *("angles", "age", "sequence", "energy", "valid", "count", "share"),
    }
)
