"""Both stations of one session beside each other: what either sent and took, and how it kept time.

The merged run's manifest has it all; of a run of one station there is no table.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from cosim.report.page.tables import seconds

TIMES = frozenset({"round_trip", "clock_offset"})
"""What of a link is a time (ns)."""
SETTINGS = frozenset({"delay", "late_after"})
"""What of a stream was set, and so is no count."""
FIRST = frozenset({"sent", "accepted"})
"""Counts that are shown first, and where they are nothing, too."""


def station_table(manifest: Mapping[str, Any]) -> dict[str, Any] | None:
    """A column for each station, a row for each number that any of them has."""
    merged: Mapping[str, Any] = manifest.get("merged") or {}
    links: Mapping[str, Mapping[str, Any]] = merged.get("links") or {}
    if not links:
        return None
    deadlines: Mapping[str, Any] = merged.get("deadlines") or {}
    columns = {
        station: {**dict(_of_link(link)), **dict(_of_deadlines(deadlines.get(station) or {}))}
        for station, link in links.items()
    }
    names = dict.fromkeys(name for column in columns.values() for name in column)
    rows = [(name, *(column.get(name, "") for column in columns.values())) for name in names]
    return {"heading": ("", *columns), "rows": rows}


def _of_link(link: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    """Times of each peer; what is counted of peers and what of their streams, summed apart.

    What was sent and what came are counted under the same names, such as ``withheld``.
    """
    peers: Mapping[str, Mapping[str, Any]] = link.get("peers") or {}
    packets, received = Counter[str](), Counter[str]()
    for peer, facts in peers.items():
        for key, value in facts.items():
            if key in TIMES and value is not None:
                name = key.replace("_", " ")
                yield (name if len(peers) == 1 else f"{name}, {peer}"), seconds(value * 1e-9)
            elif isinstance(value, int):
                packets[key] += value
        streams: Mapping[str, Mapping[str, Any]] = facts.get("streams") or {}
        for stream in streams.values():
            for key in stream.keys() - SETTINGS:
                if isinstance(stream[key], int):
                    received[key] += stream[key]
    for label, counts in (("packets", packets), ("received", received)):
        for key, count in sorted(counts.items(), key=lambda each: (each[0] not in FIRST, each[0])):
            if count or key in FIRST:
                yield f"{label}: {key.replace('_', ' ')}", str(count)


def _of_deadlines(deadlines: Mapping[str, Any]) -> Iterator[tuple[str, str]]:
    for key, value in deadlines.items():
        if isinstance(value, bool) or not isinstance(value, int | float):
            continue
        told = seconds(value) if isinstance(value, float) else str(value)
        yield f"deadlines: {key.replace('_', ' ')}", told
