"""The tree of a scenario as it was written: plain values, each with its place in a file."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from cosim.base.errors import Location

PathKey = str | int
Scalar = str | int | float | bool | None


@dataclass(slots=True)
class Node:
    """One node of the document.

    ``value`` is a scalar, a ``dict[str, Node]`` or a ``list[Node]``. ``place`` is where the value
    starts; ``key_place`` where its key does, for a member of a mapping. ``removed`` remembers the
    members that an overlay took out.
    """

    value: Scalar | dict[str, Node] | list[Node]
    place: Location
    key_place: Location | None = None
    removed: tuple[str, ...] = ()

    @property
    def is_mapping(self) -> bool:
        """Whether the node has named members."""
        return isinstance(self.value, dict)

    def child(self, key: PathKey) -> Node | None:
        """The member or item of that key, if there is one."""
        if isinstance(self.value, dict):
            return self.value.get(key) if isinstance(key, str) else None
        if isinstance(self.value, list) and isinstance(key, int) and 0 <= key < len(self.value):
            return self.value[key]
        return None

    def text(self, key: PathKey | None = None) -> str | None:
        """The text of a member (of the node itself without ``key``); ``None`` if it is no text."""
        node = self if key is None else self.child(key)
        return node.value if node is not None and isinstance(node.value, str) else None

    def find(self, path: tuple[PathKey, ...]) -> tuple[Node, int]:
        """The deepest node on ``path`` that exists, and how many keys led to it.

        A dotted key may span nested mappings.
        """
        node, depth = self, 0
        for key in path:
            found = node.child(key)
            if found is None and isinstance(key, str):
                found = node
                for part in key.split("."):
                    found = found.child(part) if found is not None else None
            if found is None:
                break
            node, depth = found, depth + 1
        return node, depth

    def locate(self, path: tuple[PathKey, ...]) -> Location:
        """The place of the deepest node on ``path``."""
        return self.find(path)[0].place

    def plain(self) -> Any:
        """The value without places: dictionaries, lists and scalars."""
        if isinstance(self.value, dict):
            return {key: node.plain() for key, node in self.value.items()}
        if isinstance(self.value, list):
            return [node.plain() for node in self.value]
        return self.value
