"""Patterns over the names of signals: ``*`` is any text and ``?`` any character, all else itself.

Names hold brackets (``box.node[1,1]``), which other kinds of pattern take for a set of characters.
"""

from __future__ import annotations

import re


def is_wild(pattern: str) -> bool:
    """Whether there is anything in it that stands for other text."""
    return any(character in pattern for character in "*?")


def compile_wildcard(pattern: str) -> re.Pattern[str]:
    """What matches a whole name, and with it all of a group or an array of that name."""
    wild = "".join({"*": ".*", "?": "."}.get(c, re.escape(c)) for c in pattern)
    return re.compile(rf"{wild}([.\[].*)?", re.DOTALL)
