"""docs/tutorial.md: every command runs, in order, and prints what the page shows."""

from __future__ import annotations

import doctest
import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import CohapticError
from cosim.cli import cli

PAGE = (Path(__file__).parents[3] / "docs" / "tutorial.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.DOTALL | re.MULTILINE)
SAME = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
PROGRAM = "uv run cohaptic "


def spoken(line: str) -> str:
    """What a command prints, on stdout and stderr, and how it ends where that is not well."""
    done = CliRunner().invoke(cli, shlex.split(line.removeprefix(PROGRAM)), standalone_mode=False)
    if isinstance(done.exception, CohapticError):
        return f"{done.output}{done.exception}\n[exit status {done.exception.exit_status}]\n"
    assert done.exception is None or isinstance(done.exception, SystemExit), done.exception
    status = done.exit_code
    return done.output + (f"[exit status {status}]\n" if status else "")


def test_every_command_prints_what_the_page_shows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    compared = 0
    for language, text in BLOCK.findall(PAGE):
        if language == "yaml":
            name = text.splitlines()[0].removeprefix("# ")
            (tmp_path / name).write_text(text, encoding="utf-8")
        if language != "console":
            continue
        for command in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
            line, _, shown = command.partition("\n")
            found = spoken(line)
            assert doctest.OutputChecker().check_output(shown, found, SAME), f"{line}\n{found}"
            compared += 1
    assert compared == 7


def test_the_commands_that_are_only_named_exist() -> None:
    (named,) = (text for language, text in BLOCK.findall(PAGE) if language == "sh")
    for line in named.splitlines():
        command, *rest = shlex.split(line, comments=True)[3:]
        group = cli
        for word in (command, *rest):
            with cli.make_context("cohaptic", ["--help"], resilient_parsing=True) as context:
                found = group.get_command(context, word) if hasattr(group, "get_command") else None
            if found is None:
                break
            group = found
        assert group is not cli, line
