"""Texts and binary values as a scenario and a variable's declaration write them.

A scenario writes a text in quotes, and binary data as ``hex:48656c6c6f`` or ``base64:SGVsbG8=``.
"""

from __future__ import annotations

import binascii
import re
from base64 import b64decode
from typing import Any, cast

from cosim.base.component import Variable, VariableType
from cosim.base.document.show import show
from cosim.base.errors import InputError
from cosim.base.texts import MOST_BYTES, encoded
from cosim.master.components.interface import size_of

_SPELLINGS = "hex:48656c6c6f or base64:SGVsbG8="


def written_text(where: str, value: Any, *, is_binary: bool) -> str | bytes:
    """A value of a scenario for the element ``where``.

    Raises:
        InputError: it is no text, not spelled as binary data is, or too long.
    """
    if is_binary:
        content = _binary(where, value)
        size = len(content)
    else:
        if not isinstance(value, str):
            raise InputError(f"{where} is a text; put {show(value)} in quotes")
        try:
            size = len(encoded(value, is_binary=False))
        except ValueError:
            raise InputError(
                f"{where} is a text, which cannot have the character NUL or half a character in it"
            ) from None
        content = value
    if size > MOST_BYTES:
        raise InputError(
            f"{where} has {size} bytes; texts and binary data of up to {MOST_BYTES} are carried"
        )
    return content


def text_start(variable: Variable) -> list[Any]:
    """The declared start of each element of a String or Binary; empty where none is declared."""
    count = size_of(variable)
    empty = b"" if variable.type is VariableType.BINARY else ""
    start: Any = empty if variable.start is None else variable.start
    if isinstance(start, tuple):
        given = list(cast("tuple[Any, ...]", start))
        return given if len(given) == count else [empty] * count
    return [start] * count


def _binary(where: str, value: Any) -> bytes:
    spelling, colon, digits = value.partition(":") if isinstance(value, str) else ("", "", "")
    if not colon or spelling not in {"hex", "base64"}:
        raise InputError(
            f"{where} is binary data: write it as {_SPELLINGS}, in quotes, not {show(value)}"
        )
    plain = re.sub(r"\s+", "", digits)
    try:
        return bytes.fromhex(plain) if spelling == "hex" else b64decode(plain, validate=True)
    except (ValueError, binascii.Error) as error:
        raise InputError(f"{where}: {show(value)} is not {spelling}: {error}") from None
