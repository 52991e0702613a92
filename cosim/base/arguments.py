"""Arguments of a caller from Python: a text is not taken letter by letter for a list of texts."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from os import PathLike
from typing import Any, cast


def texts_of(name: str, given: Any) -> tuple[Any, ...]:
    """A list of texts or paths.

    Raises:
        TypeError: it is one text, a mapping, or has something else in it.
    """
    if isinstance(given, str | PathLike):
        one = str(cast("object", given))
        raise TypeError(f"{name} is a list of texts; write {name}=[{one!r}].")
    if isinstance(given, Mapping) or not isinstance(given, Iterable):
        raise TypeError(f"{name} is a list of texts, not {given!r}.")
    found = tuple(cast("Iterable[Any]", given))
    odd = [each for each in found if not isinstance(each, str | PathLike)]
    if odd:
        raise TypeError(f"{name} is a list of texts; {odd[0]!r} is none.")
    return found
