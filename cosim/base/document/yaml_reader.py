"""YAML text to a tree of nodes, each with its place; broken YAML becomes a sentence."""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

from cosim.base.document.node import Node, Scalar
from cosim.base.document.text_file import read_text
from cosim.base.document.yaml_quick import compose_quickly
from cosim.base.document.yaml_sentence import sentence, without_value
from cosim.base.document.yaml_tabs import tab_scanner
from cosim.base.errors import InputError, Location

MAX_NODES = 100_000
"""Aliases are expanded; a file that expands to more than this is refused."""


def read_yaml(path: Path, shown: str) -> Node:
    """Read a YAML file; ``shown`` is its name in places and messages.

    Raises:
        InputError: the file cannot be read or is not YAML that a scenario can use.
    """
    return parse_yaml(read_text(path, shown), shown)


def parse_yaml(text: str, shown: str, *, has_lines: bool = True) -> Node:
    """Turn YAML 1.2 text into nodes; ``has_lines=False`` gives every node the place ``shown``.

    Raises:
        InputError: broken YAML, a duplicate key, a tag, a recursive anchor, too many nodes.
    """
    quick = compose_quickly(text)
    if quick is not None:
        try:
            return _Builder(shown, text, has_lines).build(quick, None)
        except (InputError, RecursionError):
            pass  # the careful reader explains it
    return parse_carefully(text, shown, has_lines=has_lines)


def parse_carefully(text: str, shown: str, *, has_lines: bool = True) -> Node:
    """What ``parse_yaml`` means, at the speed of Python.

    Raises:
        InputError: as ``parse_yaml``.
    """
    from ruamel.yaml import YAML
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    builder = _Builder(shown, text, has_lines)
    yaml: Any = YAML(typ="safe", pure=True)
    yaml.Scanner = tab_scanner()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # an anchor's name may be used again
            root = yaml.compose(text)
        if root is None:
            return Node(None, builder.start)
        return builder.build(root, None)
    except MarkedYAMLError as error:
        message, mark = sentence(error, text)
        raise InputError(message, builder.place(mark)) from None
    except YAMLError as error:
        before = text[: getattr(error, "position", 0)]
        place = Location(shown, before.count("\n") + 1, len(before) - before.rfind("\n"))
        message = (
            f"the control character {_code(text[len(before) :])} cannot stand here; delete it."
        )
        raise InputError(message, place if has_lines else builder.start) from None
    except RecursionError:
        raise InputError("nested too deeply to be a scenario.", builder.start) from None


class _Builder:
    """Converts ruamel's composed nodes, which carry marks and resolved tags."""

    def __init__(self, shown: str, text: str, has_lines: bool) -> None:
        self._shown = shown
        self._text = text
        self._has_lines = has_lines
        self._open: set[int] = set()
        self._count = 0

    def place(self, mark: Any) -> Location:
        if mark is None or not self._has_lines:
            return self.start
        return Location(self._shown, mark.line + 1, mark.column + 1)

    @property
    def start(self) -> Location:
        return Location(self._shown, 1, 1) if self._has_lines else Location(self._shown, 0, 0)

    def build(self, node: Any, key_place: Location | None) -> Node:
        place = self.place(node.start_mark)
        self._count += 1
        if self._count > MAX_NODES:
            raise InputError(f"more than {MAX_NODES} values, counting aliases.", place)
        if id(node) in self._open:
            raise InputError(f"the anchor &{getattr(node, 'anchor', None)} contains itself.", place)
        self._open.add(id(node))
        try:
            return Node(self._value(node, place), place, key_place)
        finally:
            self._open.discard(id(node))

    def _value(self, node: Any, place: Location) -> Scalar | dict[str, Node] | list[Node]:
        if node.id == "mapping":
            return self._mapping(node)
        if node.id == "sequence":
            return [self.build(item, None) for item in node.value]
        return _scalar(str(node.tag), node.value, place)

    def _mapping(self, node: Any) -> dict[str, Node]:
        members: dict[str, Node] = {}
        inherited: dict[str, Node] = {}
        before: Any = None
        for key, value in node.value:
            place = self.place(key.start_mark)
            if node.flow_style and _is_bare(key, value):
                raise self._without_value(key, before)
            before = value
            if key.id != "scalar":
                raise InputError("a key must be a plain name.", place)
            if str(key.tag).endswith(":merge"):
                for inner, member in self._merged(value, place).items():
                    inherited.setdefault(inner, member)
                continue
            name = _joined(key.value, place)
            if name in members:
                first = members[name].key_place
                raise InputError(f"'{name}' is here twice; it is first at {first}.", place)
            members[name] = self.build(value, place)
        return {**inherited, **members}

    def _without_value(self, key: Any, before: Any) -> InputError:
        start = key.start_mark.index
        glued, mark = "", key.start_mark
        if before is not None and before.id == "scalar" and before.end_mark.index == start - 1:
            glued, mark = str(before.value), before.start_mark
        message = without_value(str(key.value), glued, self._text[start - 1 : start])
        return InputError(message, self.place(mark if glued else key.start_mark))

    def _merged(self, value: Any, place: Location) -> dict[str, Node]:
        """The members that ``<<: *anchor`` or ``<<: [*a, *b]`` brings; earlier anchors win."""
        found: dict[str, Node] = {}
        for source in value.value if value.id == "sequence" else [value]:
            built = self.build(source, place).value
            if not isinstance(built, dict):
                raise InputError("'<<' takes the alias of a mapping, as in '<<: *name'.", place)
            found = {**built, **found}
        return found


def _is_bare(key: Any, value: Any) -> bool:
    """Whether a member of ``{…}`` is a key alone, without ':'."""
    return value.id == "scalar" and key.end_mark.index == value.start_mark.index


def _code(text: str) -> str:
    return f"U+{ord(text[:1] or chr(0)):04X}"


def _scalar(tag: str, text: str, place: Location) -> Scalar:
    kind = tag.removeprefix("tag:yaml.org,2002:")
    if kind == "null":
        return None
    if kind == "bool":
        return text.casefold() == "true"
    if kind in {"int", "float"}:
        try:
            return _integer(text, place) if kind == "int" else _real(text)
        except InputError:
            raise
        except ValueError:
            raise InputError(f"'{text[:40]}' is not a number that fits.", place) from None
    if kind in {"str", "timestamp"}:
        return _joined(text, place)
    tag = tag.replace("tag:yaml.org,2002:", "!!")
    raise InputError(f"the tag '{tag}' has no meaning in a scenario; leave it out.", place)


def _joined(text: str, place: Location) -> str:
    """Text whose escaped surrogate pairs (as JSON writes them) are the characters they mean."""
    if text.isascii() or not any("\ud800" <= character <= "\udfff" for character in text):
        return text
    try:
        return text.encode("utf-16", "surrogatepass").decode("utf-16")
    except UnicodeDecodeError:
        raise InputError("half of a surrogate pair is no character.", place) from None


def _integer(text: str, place: Location) -> int:
    digits = text.replace("_", "")
    if re.fullmatch(r"[+-]?0\d+", digits):
        message = f"'{text[:40]}' begins with 0, which some read as octal; write {int(digits)}."
        raise InputError(message, place)
    prefixed = digits.lstrip("+-")[:2] in {"0x", "0o", "0b"}
    return int(digits, 0 if prefixed else 10)


def _real(text: str) -> float:
    return float(text.replace("_", "").casefold().replace(".inf", "inf").replace(".nan", "nan"))
