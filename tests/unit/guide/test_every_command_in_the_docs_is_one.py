"""Every command line that a page shows names a command and options that there are.

``tests/system/guide`` runs those of blocks; here those within the text are read, too.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator

import click
import pytest

from cosim.cli import cli
from tests.support.guide.blocks import PAGES, ROOT, commands

BLOCK = re.compile(r"^ *```.*?^ *```", re.DOTALL | re.MULTILINE)
LINE = re.compile(r"(?:\w+=\S+ )*(?:uv run (?:--\S+ \S+ )?)?(cohaptic .*)")
INLINE = re.compile(r"`(cohaptic [^`]+)`")
MEANT = re.compile(r"…|\.\.\.|\[|\||[A-Z]{3,}")
"""What stands for something else; options before it are read all the same."""


def shown() -> Iterator[tuple[str, str]]:
    for each in commands():
        if found := LINE.match(each.line):
            yield each.page, found[1]
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for line in INLINE.findall(BLOCK.sub("", text)):
            yield page.relative_to(ROOT).as_posix(), " ".join(line.split())


LINES = sorted(set(shown()))


def words_of(line: str) -> list[str]:
    try:
        words = shlex.split(line, comments=True)[1:]
    except ValueError:
        words = line.split()[1:]
    ends = [index for index, word in enumerate(words) if word in {"|", ">", "&&", "&", ";", "2>"}]
    return words[: ends[0]] if ends else words


def refused(line: str) -> str:
    """Why click would not read it; empty where it would."""
    command: click.Command = cli
    words = words_of(line)
    context = click.Context(cli, info_name="cohaptic")
    while isinstance(command, click.Group):
        if not words or words[0].startswith("-") or MEANT.search(words[0]):
            return ""
        found = command.get_command(context, words[0])
        if found is None:
            return f"there is no command {words[0]}"
        command, words = found, words[1:]
        context = click.Context(command, info_name=command.name, parent=context)
    try:
        command.make_parser(context).parse_args(words)
    except click.NoSuchOption as error:
        return error.format_message()
    except click.UsageError as error:
        return "" if any(MEANT.search(word) for word in words) else error.format_message()
    return ""


def test_there_are_many() -> None:
    assert len(LINES) > 100


@pytest.mark.parametrize(("page", "line"), LINES)
def test_a_command_line_can_be_read(page: str, line: str) -> None:
    assert refused(line) == "", f"{page}: {line}"


def test_what_is_none_is_told() -> None:
    assert "no command" in refused("cohaptic fly")
    assert "--fast" in refused("cohaptic run two_users_box --fast")
