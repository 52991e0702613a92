"""Every key of a form and of the forms inside it, found in the forms themselves."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel

FOR_READERS = {"title", "description"}

Key = tuple[str, str]
"""Name of a form, and a key of it as it is written."""


def keys_of(*roots: type[BaseModel]) -> set[Key]:
    """Every key that has more than one legal value and is not for readers alone."""
    found: set[Key] = set()
    for form in forms_in(*roots):
        for name, field in form.model_fields.items():
            key = field.alias or name
            if key not in FOR_READERS and not _has_one_value(field.annotation):
                found.add((form.__name__, key))
    return found


def forms_in(*roots: type[BaseModel]) -> list[type[BaseModel]]:
    """The forms and every form inside them, each once."""
    found: list[type[BaseModel]] = []
    todo = list(roots)
    while todo:
        form = todo.pop()
        if form in found:
            continue
        found.append(form)
        for field in form.model_fields.values():
            todo += _forms(field.annotation)
            for note in field.metadata:
                todo += _forms(note)
        todo += _forms(getattr(form, "any_other", None))
    return found


def _forms(kind: Any) -> Generator[type[BaseModel]]:
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        yield kind
    for inner in get_args(kind):
        yield from _forms(inner)


def _has_one_value(kind: Any) -> bool:
    return get_origin(kind) is Literal and len(get_args(kind)) == 1
