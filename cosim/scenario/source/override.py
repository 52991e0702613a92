"""``--set a.b=c``: an overlay with a single value in it, written on the command line."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from pathlib import Path

from cosim.base.document.node import Node, PathKey
from cosim.base.document.yaml_reader import parse_yaml
from cosim.base.errors import InputError, Location
from cosim.base.suggest import did_you_mean
from cosim.scenario.source.include import expand
from cosim.scenario.source.merge import is_dotted, merge, normalise

NAMED_SECTIONS = ("components", "channels", "rates")
"""Sections whose members the user named: a new name there is more likely a misspelt one."""


def apply_override(root: Node, text: str) -> Node:
    """``root`` with one ``path=value`` over it; the value is YAML, ``~`` removes.

    Raises:
        InputError: no ``=``, a value that is not YAML, or a path that leads nowhere.
    """
    place = Location(f"--set {text}", 0, 0)
    path, equals, written = text.partition("=")
    if not equals or not path.strip():
        raise InputError("write --set path.to.key=value.", place)
    value = _value(written, place)
    keys = _keys(root, path.strip(), value, place)
    _refuse_anchors(root, keys, written.strip(), place)
    return _assign(root, keys, expand(value, tuple(keys), Path.cwd()), ())


def put(root: Node, keys: Sequence[str], written: str, given: str) -> Node:
    """``root`` with the value ``written`` (YAML) at ``keys``; ``given`` is the whole override.

    Raises:
        InputError: the value is not YAML.
    """
    value = _value(written, Location(f"--set {given}", 0, 0))
    return _assign(root, list(keys), expand(value, tuple(keys), Path.cwd()), ())


def _value(written: str, place: Location) -> Node:
    if not written.strip():
        raise InputError("there is no value behind '='; '~' removes.", place)
    return parse_yaml(written, place.file, has_lines=False)


def _refuse_anchors(root: Node, keys: list[PathKey], written: str, place: Location) -> None:
    """Under ``x-…`` nothing is obeyed: what is there was copied to where its alias stands."""
    if not str(keys[0]).startswith("x-"):
        return
    where = ".".join(map(str, keys))
    used = copies_of(root, where)
    if used:
        listed = " and ".join(f"--set {name}={written}" for name in used)
        raise InputError(f"'{where}' only holds what is used elsewhere: write {listed}.", place)
    raise InputError(
        f"'{where}' is a place for anchors, and an alias copies it when the file is read: set the "
        "key where the alias stands, such as components.NAME.parameters.KEY.",
        place,
    )


def copies_of(root: Node, path: str) -> list[str]:
    """The paths outside ``x-…`` that an alias has copied a value under ``x-…`` to."""
    keys = tuple(path.split("."))
    node, depth = root.find(keys)
    return list(_copies(root, node.place, ())) if depth == len(keys) and node.place.line else []


def _copies(node: Node, place: Location, path: tuple[PathKey, ...]) -> Generator[str]:
    """The paths outside ``x-…`` of what was written at a place."""
    if path and node.place == place:
        yield ".".join(map(str, path))
        return
    members: dict[str, Node] = node.value if isinstance(node.value, dict) else {}
    for key, member in members.items():
        if path or not key.startswith("x-"):
            yield from _copies(member, place, (*path, key))
    if isinstance(node.value, list):
        for index, item in enumerate(node.value):
            yield from _copies(item, place, (*path, index))


def _keys(root: Node, path: str, value: Node, place: Location) -> list[PathKey]:
    """The keys that lead to the value; a member's own name may contain dots."""
    keys: list[PathKey] = []
    node: Node | None = root
    rest = path.split(".")
    if not all(rest):
        raise InputError(f"'{path}' has an empty part; write path.to.key.", place)
    while rest:
        if is_dotted(tuple(keys)):
            return [*keys, ".".join(rest)]
        if node is not None and not isinstance(node.value, dict | list | None):
            where = ".".join(map(str, keys))
            raise InputError(f"'{where}' is a single value; nothing is inside it.", place)
        if node is not None and isinstance(node.value, list):
            key, used = _index(node.value, rest[0], ".".join(map(str, keys)), place), 1
        else:
            key, used = _member(node, rest)
            _check_name(node, keys, key, value if used == len(rest) else None, place)
        keys.append(key)
        rest = rest[used:]
        node = node.child(key) if node is not None else None
    return keys


def _member(node: Node | None, rest: list[str]) -> tuple[str, int]:
    """The longest run of parts that is a member's name, or the first part as a new name."""
    for used in range(len(rest), 0, -1):
        key = ".".join(rest[:used])
        if node is not None and node.child(key) is not None:
            return key, used
    return rest[0], 1


def _index(items: list[Node], part: str, where: str, place: Location) -> int:
    if not part.isdecimal() or int(part) >= len(items):
        inside = f"items 0 to {len(items) - 1}" if items else "no items"
        raise InputError(f"'{where}' is a list with {inside}; there is no '{part}'.", place)
    return int(part)


def _check_name(
    node: Node | None, keys: list[PathKey], key: str, value: Node | None, place: Location
) -> None:
    if len(keys) != 1 or keys[0] not in NAMED_SECTIONS or node is None or node.child(key):
        return
    if value is not None and value.is_mapping:
        return
    known = node.value if isinstance(node.value, dict) else {}
    what = str(keys[0]).removesuffix("s")
    raise InputError(f"there is no {what} '{key}'.{did_you_mean(key, known)}", place)


def _assign(node: Node, keys: list[PathKey], value: Node, at: tuple[PathKey, ...]) -> Node:
    """Merge the value in at the end of the path, descending through lists by index."""
    for depth, key in enumerate(keys):
        if isinstance(key, int):
            inner, _ = node.find(tuple(keys[:depth]))
            assert isinstance(inner.value, list)
            items = list(inner.value)
            items[key] = _assign(items[key], keys[depth + 1 :], value, (*at, *keys[: depth + 1]))
            return _replace(node, keys[:depth], Node(items, inner.place, inner.key_place))
    over = value
    for key in reversed(keys):
        over = Node({str(key): over}, value.place, value.place)
    return merge(node, normalise(over, at), at)


def _replace(node: Node, keys: list[PathKey], new: Node) -> Node:
    """``node`` with the node at ``keys`` (mapping members that exist) exchanged."""
    if not keys:
        return new
    assert isinstance(node.value, dict)
    key = str(keys[0])
    inner = _replace(node.value[key], keys[1:], new)
    return Node({**node.value, key: inner}, node.place, node.key_place, node.removed)
