"""The live page's colours, for pictures made elsewhere."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from pathlib import Path

STYLE = Path(__file__).parents[1] / "live" / "page" / "style.css"

Colour = tuple[int, int, int]


@cache
def colours(scheme: str = "light") -> Mapping[str, Colour]:
    """Red, green and blue (0 to 255) by the names of the style sheet, ``light`` or ``dark``."""
    blocks = re.findall(r":root \{(.*?)\}", STYLE.read_text(encoding="utf-8"), re.DOTALL)
    found: dict[str, Colour] = {}
    for block in blocks[: 1 if scheme == "light" else 2]:
        for name, value in re.findall(r"--([\w-]+): #([0-9a-f]{6});", block):
            red, green, blue = bytes.fromhex(value)
            found[name] = red, green, blue
    return found


def mixed(colour: Colour, ground: Colour, share: float) -> Colour:
    """``share`` of a colour over the ground, as if it let the rest through."""
    red, green, blue = (
        round(share * over + (1 - share) * under)
        for over, under in zip(colour, ground, strict=True)
    )
    return red, green, blue
