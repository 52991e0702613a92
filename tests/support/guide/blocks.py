"""The command lines that the pages show in fenced blocks, in their order."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[3]
PAGES = sorted([*ROOT.glob("*.md"), *ROOT.glob("docs/*.md"), *ROOT.glob("fmus/*/README.md")])
_BLOCK = re.compile(r"^( *)```(\w*)\n(.*?)^\1```", re.DOTALL | re.MULTILINE)
_SHELLS = {"", "sh", "bash", "shell", "console"}
_COMMAND = re.compile(r"(?:\w+=\S+ )*(?:cohaptic|uv|pip|git|docker|python|sudo|apt-get) (?! )")


@dataclass(frozen=True, slots=True)
class Shown:
    """One command line of a page."""

    page: str
    """From the repository's root."""
    line: str
    """Without the prompt, continued lines joined, without a comment."""


def blocks_of(page: Path) -> Iterator[tuple[str, str]]:
    """Language and text of each fenced block."""
    for _, language, text in _BLOCK.findall(page.read_text(encoding="utf-8")):
        yield language, text


def commands() -> list[Shown]:
    """Every command of every page."""
    return [
        Shown(page.relative_to(ROOT).as_posix(), line)
        for page in PAGES
        for language, text in blocks_of(page)
        if language in _SHELLS
        for line in _lines(text)
    ]


def _lines(text: str) -> Iterator[str]:
    """What somebody would type; where there are prompts, what stands without one is an answer."""
    lines = [line.strip() for line in re.sub(r"\\\n\s*", "", text).splitlines()]
    prompted = any(line.startswith("$ ") for line in lines)
    for line in lines:
        if prompted and not line.startswith("$ "):
            continue
        said = re.sub(r"\s+# .*", "", line.removeprefix("$ ")).strip()
        if prompted or _COMMAND.match(said):
            yield said
