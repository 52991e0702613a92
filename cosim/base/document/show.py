"""How values are named in messages: in the spelling of YAML, never in Python's."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast

LONGEST = 60

TRUTH = {"yes": True, "on": True, "y": True, "no": False, "off": False, "n": False}
"""What other languages call true and false; here both are written out."""


def show(value: Any) -> str:
    """A value as it is written in YAML: ``true``, ``'abc'``, ``[1, 2]``, ``.inf``; cut if long."""
    text = _written(value)
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."


def describe(value: Any) -> str:
    """A value with what it is: ``the text 'abc'``, ``a list``, ``true``."""
    if value is None:
        return "nothing"
    if isinstance(value, str):
        return f"the text '{value if len(value) <= LONGEST else value[: LONGEST - 3] + '...'}'"
    if isinstance(value, Mapping):
        return "a mapping"
    return "a list" if isinstance(value, list | tuple) else show(value)


def truth_hint(value: Any) -> str:
    """For a value where true or false is due, which of the two it seems to mean."""
    meant = TRUTH.get(value.casefold()) if isinstance(value, str) else None
    if isinstance(value, str) and value.casefold() in {"true", "false"}:
        meant = value.casefold() == "true"
    return "" if meant is None else f"; write {show(meant)} without quotes"


def _written(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float) and not math.isfinite(value):
        return ".nan" if math.isnan(value) else ".inf" if value > 0 else "-.inf"
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, Mapping):
        members = cast("Mapping[Any, Any]", value)
        return "{" + ", ".join(f"{key}: {_written(v)}" for key, v in members.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_written(item) for item in cast("list[Any]", value)) + "]"
    return str(value)
