"""Plain data to YAML that reads back as exactly the same data: block mappings, short lists in line.

General YAML writers leave some characters (a NEL in a key, say) such that they read back as others;
here a text that is not plainly a word is written the way JSON does.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any, cast

_WORD = re.compile(r"[A-Za-z][\w.*\[\]/]*(?: [\w.*\[\]/>-]+)*", re.ASCII)
_INLINE_WORD = re.compile(r"[A-Za-z][\w./]*(?: [\w./]+)*", re.ASCII)
_OTHER_MEANING = {"true", "false", "null", "yes", "no", "on", "off", "y", "n"}
LONGEST_LINE = 96


def write_yaml(document: Mapping[str, Any]) -> str:
    """The document as YAML text; values are mappings, sequences, text, numbers, booleans."""
    return "".join(f"{line}\n" for line in _members(document, ""))


def _members(mapping: Mapping[str, Any], indent: str) -> list[str]:
    lines: list[str] = []
    for key, value in mapping.items():
        lines += _entry(f"{indent}{_scalar(key)}:", value, indent)
    return lines


def _items(sequence: Sequence[Any], indent: str) -> list[str]:
    lines: list[str] = []
    for item in sequence:
        inline = _inline(item) if isinstance(item, Mapping | list) else _scalar(item)
        if isinstance(item, Mapping) and len(inline) + len(indent) > LONGEST_LINE and item:
            first, *rest = _members(cast("Mapping[str, Any]", item), f"{indent}  ")
            lines += [f"{indent}- {first.lstrip()}", *rest]
        else:
            lines.append(f"{indent}- {inline}")
    return lines


def _entry(head: str, value: Any, indent: str) -> list[str]:
    inline = f"{head} {_inline(value) if isinstance(value, Mapping | list) else _scalar(value)}"
    if isinstance(value, Mapping) and value:
        members = cast("Mapping[str, Any]", value)
        if any(isinstance(v, Mapping | list) for v in members.values()) or len(inline) > 60:
            return [head, *_members(members, f"{indent}  ")]
    if isinstance(value, list) and value:
        items = cast("list[Any]", value)
        if len(inline) > LONGEST_LINE or not all(isinstance(v, int | float) for v in items):
            return [head, *_items(items, f"{indent}  ")]
    return [inline]


def _inline(value: Any) -> str:
    if isinstance(value, Mapping):
        members = cast("Mapping[str, Any]", value).items()
        return (
            "{"
            + ", ".join(f"{_scalar(key, _INLINE_WORD)}: {_inline(v)}" for key, v in members)
            + "}"
        )
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_inline(item) for item in cast("list[Any]", value)) + "]"
    return _scalar(value, _INLINE_WORD)


def _scalar(value: Any, word: re.Pattern[str] = _WORD) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return repr(value) if math.isfinite(value) else f"{value:+}".replace("inf", ".inf")
    if value is None or isinstance(value, int):
        return "null" if value is None else str(value)
    text = str(value)
    if word.fullmatch(text) and text.casefold() not in _OTHER_MEANING:
        return text
    return json.dumps(text, ensure_ascii=not text.isprintable())
