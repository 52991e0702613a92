"""Every example of docs/scenario.md works, and shows what the program says."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from cosim.base.errors import CohapticError
from cosim.cli.check import command
from cosim.master.run.simulation import assemble
from cosim.scenario import load

PAGE = Path(__file__).parents[3] / "docs" / "scenario.md"
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE)
(TABLE,) = [text for language, text in BLOCKS if language == "csv"]
EXAMPLES = [text for language, text in BLOCKS if language == "yaml"]
SESSIONS = [text for language, text in BLOCKS if language == "console"]
COMMANDS = [part for text in SESSIONS for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]]


@pytest.mark.parametrize("number", range(len(EXAMPLES)))
def test_each_example_can_be_put_together(number: int, tmp_path: Path) -> None:
    text = EXAMPLES[number]
    file = tmp_path / "example.yaml"
    file.write_text(text, encoding="utf-8")
    (tmp_path / "hand.csv").write_text(TABLE, encoding="utf-8")
    base = re.match(r"# over (\w+)", text)
    scenario = load(base[1], [file]) if base else load(file)
    with assemble(scenario):
        pass


@pytest.mark.parametrize("number", range(len(COMMANDS)))
def test_each_command_says_what_is_shown(number: int) -> None:
    line, _, shown = COMMANDS[number].partition("\n")
    program, name, *arguments = shlex.split(line)
    assert (program, name) == ("cohaptic", "check")
    result = CliRunner().invoke(command, arguments)
    if shown:
        assert isinstance(result.exception, CohapticError)
        assert result.exception.exit_status == 2
        assert str(result.exception) == shown.strip()
    else:
        assert result.exception is None, result.exception


def test_the_page_has_examples() -> None:
    assert len(EXAMPLES) >= 6
    assert len(COMMANDS) >= 4
