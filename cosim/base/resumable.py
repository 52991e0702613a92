"""What can be saved as plain values and go on from them later, in another process as well."""

from __future__ import annotations

from typing import Any, Protocol, cast, runtime_checkable


@runtime_checkable
class Resumable(Protocol):
    """Offers ``save`` and ``load``; a component or a stream of draws that remembers something.

    Plain values are ``None``, booleans, whole numbers, floats, texts, and lists and dictionaries
    (with texts as keys) of them.
    """

    def save(self) -> Any:
        """Everything that the future depends on, as plain values."""
        ...

    def load(self, values: Any) -> None:
        """Go on from what ``save`` returned; called once all else is as it was then.

        Raises:
            TypeError, ValueError: these are not values of this object.
        """
        ...


def not_plain(value: Any, place: str = "") -> str | None:
    """Where a value is not plain, and its type; ``None`` where all of it is."""
    if value is None or type(value) in {bool, int, float, str}:
        return None
    if type(value) is list:
        items = enumerate(cast("list[Any]", value))
        return next((bad for i, item in items if (bad := not_plain(item, f"{place}[{i}]"))), None)
    if type(value) is dict:
        for key, item in cast("dict[Any, Any]", value).items():
            if type(key) is not str:
                return f"a key of type {type(key).__name__}{_at(place)}"
            if bad := not_plain(item, f"{place}[{key!r}]"):
                return bad
        return None
    return f"a value of type {type(value).__name__}{_at(place)}"


def _at(place: str) -> str:
    return f" at {place}" if place else ""
