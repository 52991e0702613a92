"""A document's members that can be read; those that cannot are reported, and hide no others."""

from __future__ import annotations

from typing import Any, cast

from pydantic import ValidationError

from cosim.base.document.form import ready
from cosim.base.document.node import Node, PathKey
from cosim.base.document.problems import Problems, independent
from cosim.scenario.build.context import Context
from cosim.scenario.form.document import Document

SECTIONS = (
    *("components", "channels", "rates", "connections"),
    *("knobs", "events", "record", "expect"),
)
"""Sections whose members are checked one by one, so that one bad member hides no other."""

LISTS = ("connections", "events", "record")

PLACEHOLDERS: dict[str, Any] = {"cohaptic": 1, "duration": 1, "components": {}}
"""Stand in for required keys that are missing or wrong while the rest is checked."""


def validated(root: Node, problems: Problems, form: type[Document]) -> Context:
    """The document without its bad members, which are reported."""
    ready(form)
    reported: set[tuple[PathKey, ...]] = set()
    dropped: set[tuple[PathKey, ...]] = set()
    while True:
        document_as_written, kept = _without(root.plain(), dropped)
        try:
            document = form.model_validate(document_as_written)
            return Context(
                root=root, problems=problems, document=document, kept=kept, doubtful=reported
            )
        except ValidationError as error:
            before = len(dropped)
            findings = error.errors(include_url=False)
            told = independent(findings)
            for finding in findings:
                path = _as_written(finding["loc"], kept)
                member = path[: 2 if path[0] in SECTIONS else 1]
                is_extra = finding["type"] == "extra_forbidden"
                if member not in reported and finding in told:
                    problems.add_validation({**finding, "loc": path})
                dropped.add(path if is_extra else member)
            assert len(dropped) > before, "each round drops what it found"
            # What is left of a member may be wrong only because of what was dropped from it.
            reported = {path[: 2 if path[0] in SECTIONS else 1] for path in dropped}


def _as_written(loc: tuple[PathKey, ...], kept: dict[str, list[int]]) -> tuple[PathKey, ...]:
    """Pydantic's path with the index that an item had before bad ones were left out."""
    if len(loc) > 1 and isinstance(loc[1], int) and loc[0] in kept:
        return (loc[0], kept[str(loc[0])][loc[1]], *loc[2:])
    return loc


def _without(
    written: dict[str, Any], dropped: set[tuple[PathKey, ...]]
) -> tuple[dict[str, Any], dict[str, list[int]]]:
    """The plain document without the dropped nodes, and the index of each item that is left."""
    for path in dropped:
        inner: Any = written
        for key in path[:-1]:  # union tags are in the path, but not in the document
            if isinstance(inner, list) or (isinstance(inner, dict) and key in inner):
                inner = cast("Any", inner)[key]
        if isinstance(inner, dict):
            cast("dict[PathKey, Any]", inner).pop(path[-1], None)
    written |= {key: PLACEHOLDERS[key] for key in PLACEHOLDERS if (key,) in dropped}
    kept: dict[str, list[int]] = {}
    for key in LISTS:
        items = written.get(key)
        if isinstance(items, list):
            given = cast("list[Any]", items)
            kept[key] = [i for i in range(len(given)) if (key, i) not in dropped]
            written[key] = [given[i] for i in kept[key]]
    return written, kept
