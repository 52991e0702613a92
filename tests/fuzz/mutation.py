"""Files that were right, and no longer are: bytes, lines, values, blocks; the same every time."""

from __future__ import annotations

import random
import re

VALUES = (
    *(".nan", ".inf", "-.inf", "1e999", "-1", "0", "1e-320", "1e308", "~", "true", "'1'", "''"),
    *("{}", "[]", "[1, 2]", "{a: 1}", "1 s", "5 ms", "1/0", "0x10", "1_000", "1,5", "!!int x"),
    *("*x", "&x 1", "<<", "2026-13-45", "é", "12 parsecs", "mock://", "a.b -> c.d", "|", "nan"),
    *("inf s", "nan mm", "1e400 m", "99999999999999999999", "-0.0", "infinity", "1e308 km"),
)
_SCALAR = re.compile(r"(?<=[:,\[] )[^\s,\]\[}{#]+|(?<=\[)[^\s,\]\[}{#]+|(?<=- )[^\s,\]\[}{#]+")
_KEY = re.compile(r"[A-Za-z_]\w*(?=:)")
_INLINE = re.compile(r"\{[^{}]*\}|\[[^\[\]]*\]")


def mutated(text: str, draw: random.Random) -> bytes:
    """The text with one to three things done to it."""
    data = text
    for _ in range(draw.randint(1, 3)):
        data = draw.choice((_value, _value, _value, _key, _line, _block, _swap))(data, draw)
    raw = data.encode("utf-8", "surrogateescape")
    return _bytes(raw, draw) if draw.random() < 0.2 else raw


def _bytes(raw: bytes, draw: random.Random) -> bytes:
    place = draw.randrange(len(raw) + 1)
    new = bytes(draw.randrange(256) for _ in range(draw.randrange(4)))
    return raw[:place] + new + raw[place + draw.randrange(4) :]


def _put(text: str, found: re.Match[str], new: str) -> str:
    return text[: found.start()] + new + text[found.end() :]


def _value(text: str, draw: random.Random) -> str:
    found = list(_SCALAR.finditer(text))
    return _put(text, draw.choice(found), draw.choice(VALUES)) if found else text


def _key(text: str, draw: random.Random) -> str:
    found = list(_KEY.finditer(text))
    if not found:
        return text
    other = draw.choice(found).group()
    one = draw.choice(found)
    return _put(text, one, draw.choice((other, one.group()[:-1], one.group() + "x", "")))


def _line(text: str, draw: random.Random) -> str:
    lines = text.split("\n")
    place = draw.randrange(len(lines))
    match draw.randrange(4):
        case 0:
            del lines[place]
        case 1:
            lines.insert(draw.randrange(len(lines)), lines[place])
        case 2:
            lines[place] = " " * draw.randrange(5) + lines[place].lstrip()
        case _:
            lines[place] = lines[place][: draw.randrange(len(lines[place]) + 1)]
    return "\n".join(lines)


def _block(text: str, draw: random.Random) -> str:
    """An inline list or mapping replaced by a plain value."""
    found = list(_INLINE.finditer(text))
    return _put(text, draw.choice(found), draw.choice(VALUES)) if found else text


def _swap(text: str, draw: random.Random) -> str:
    """Two inline subtrees change places."""
    found = list(_INLINE.finditer(text))
    if len(found) < 2:
        return text
    first, second = sorted(draw.sample(found, 2), key=lambda m: m.start())
    return (
        text[: first.start()]
        + second.group()
        + text[first.end() : second.start()]
        + first.group()
        + text[second.end() :]
    )
