"""The tree of a scenario as it was written: plain values, each with its place in a file."""

from __future__ import annotations

from dataclasses import dataclass

from cosim.errors import Location

PathKey = str | int
Scalar = str | int | float | bool | None


@dataclass(slots=True)
class Node:
    """One node of the document.

    ``value`` is a scalar, a ``dict[str, Node]`` or a ``list[Node]``. ``place`` is where the value
    starts; ``key_place`` where its key does, for a member of a mapping.
    """

    value: Scalar | dict[str, Node] | list[Node]
    place: Location
    key_place: Location | None = None

    def child(self, key: PathKey) -> Node | None:
        """The member or item of that key, if there is one."""
        if isinstance(self.value, dict):
            return self.value.get(key) if isinstance(key, str) else None
        if isinstance(self.value, list) and isinstance(key, int) and 0 <= key < len(self.value):
            return self.value[key]
        return None

    def locate(self, path: tuple[PathKey, ...]) -> Location:
        """The place of the deepest node on ``path``; a dotted key may span nested groups."""
        node = self
        keys = list(path)
        while keys:
            key = keys.pop(0)
            found = node.child(key)
            if found is None and isinstance(key, str) and "." in key:
                head, _, tail = key.partition(".")
                keys.insert(0, tail)
                found = node.child(head)
            if found is None:
                break
            node = found
        return node.place
