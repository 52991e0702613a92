"""Ordinary YAML at the speed of libyaml; whatever is not ordinary is left to the careful reader.

libyaml reads YAML 1.1, the careful reader 1.2, and they differ at the edges. So this one takes only
texts of which both make the same, and gives up on every other: on each character and number whose
meaning could be in doubt, and on each mistake, which the careful reader explains.
"""

from __future__ import annotations

import importlib
import re
from functools import cache
from typing import Any

MAX_DEPTH = 100
"""Composing recurses in C; deeper texts are for the careful reader, which can say so."""

_UNUSUAL = re.compile(
    r"[^\n -~\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]"  # also tab, CR, BOM
    r"|[\u2028\u2029]"
    r"|!"  # a tag
    r"|^%"  # a directive
    r"|^(?:---|\.\.\.)"  # a document's beginning or end
    r"|[|>][-+0-9]* *\n(?:\n)* +\n",  # text whose first lines are blanks: how deep is it?
    re.MULTILINE,
)
_WHOLE = re.compile(r"[-+]?(?:0|[1-9][0-9]*)")
_REAL = re.compile(r"[-+]?(?:0|[1-9][0-9]*)(?:\.[0-9]*)?(?:[eE][-+]?[0-9]+)?")
_NUMBER_LIKE = re.compile(r"[-+.0-9_][-+.0-9_a-fA-FxXoObBiInN]*")
_WORDS = {
    **dict.fromkeys(("true", "True", "TRUE", "false", "False", "FALSE"), "bool"),
    **dict.fromkeys(("~", "null", "Null", "NULL"), "null"),
    "<<": "merge",
}
_PREFIX = "tag:yaml.org,2002:"


class _Unsure(Exception):
    """The careful reader has to look at it."""


def compose_quickly(text: str) -> Any | None:
    """The composed root node, as the careful reader would have it; ``None`` where that is unsure.

    Nodes have ``id``, ``tag``, ``value``, ``start_mark`` and ``end_mark``, as ruamel's do.
    """
    if _UNUSUAL.search(text):
        return None
    composer, broken = _composer()
    if composer is None:
        return None
    try:
        return composer(text).get_single_node()
    except (_Unsure, broken, UnicodeError):
        return None


def _tag(text: str) -> str:
    """What a plain scalar is.

    Raises:
        _Unsure: 1.1 and 1.2 may see it differently, or it is nothing at all.
    """
    if text in _WORDS:
        return _PREFIX + _WORDS[text]
    if _WHOLE.fullmatch(text):
        return _PREFIX + "int"
    if _REAL.fullmatch(text):
        return _PREFIX + "float"
    if not text or text == "=" or _NUMBER_LIKE.fullmatch(text):
        raise _Unsure
    return _PREFIX + "str"


@cache
def _composer() -> tuple[Any | None, Any]:
    """A composer with the scalars of YAML 1.2 (none without libyaml), and what it raises."""
    yaml: Any = importlib.import_module("yaml")
    if not yaml.__with_libyaml__:
        return None, yaml.YAMLError
    parser: Any = yaml.cyaml.CParser
    scalar, mapping = yaml.ScalarNode, yaml.MappingNode

    class Composer(parser):
        """Composes with our tags and a limit to the depth."""

        depth = 0

        def descend_resolver(self, parent: Any, index: Any) -> None:
            """A node begins."""
            self.depth += 1
            if self.depth > MAX_DEPTH:
                raise _Unsure

        def ascend_resolver(self) -> None:
            """A node ends."""
            self.depth -= 1

        def resolve(self, kind: Any, value: Any, implicit: Any) -> str:
            """The tag of a node that has none."""
            if kind is scalar:
                return _tag(value) if implicit[0] else _PREFIX + "str"
            return _PREFIX + ("map" if kind is mapping else "seq")

    return Composer, yaml.YAMLError
