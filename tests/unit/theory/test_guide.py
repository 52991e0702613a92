"""docs/theory.md: its commands exist with the options that it shows, and its Python runs."""

from __future__ import annotations

import shlex
from pathlib import Path

from click import Context

from cosim.cli.theory import SUBCOMMANDS, command

GUIDE = (Path(__file__).parents[3] / "docs" / "theory.md").read_text(encoding="utf-8")


def test_every_command_of_the_guide_parses() -> None:
    lines = [line for line in GUIDE.splitlines() if line.startswith("uv run cohaptic theory ")]
    shown: set[str] = set()
    for line in lines:
        name, *arguments = shlex.split(line)[4:]
        shown.add(name)
        parent = Context(command)
        found = command.get_command(parent, name)
        assert found is not None, name
        found.make_context(name, arguments, parent=parent)
    assert shown == set(SUBCOMMANDS) - {"page"}


def test_the_python_of_the_guide_runs() -> None:
    code = GUIDE.split("```python\n")[1].split("```")[0]
    space: dict[str, object] = {}
    exec(code, space)
    assert "model" in space
