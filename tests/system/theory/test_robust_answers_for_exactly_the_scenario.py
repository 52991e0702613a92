"""``theory robust --scenario`` answers for the run's own loop, or refuses with both radii."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.analysis.exact_loop import refuse_another_loop
from cosim.analysis.loop import read_loop
from cosim.base.errors import InputError
from cosim.cli.theory.robust.ports import command
from cosim.scenario.load import read


def test_a_loop_of_the_chapters_is_answered_for() -> None:
    done = CliRunner().invoke(command, ["--scenario", "single_axis_distributed", "--json"])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["stable"] is True


@pytest.mark.parametrize(
    ("name", "sets", "said"),
    [
        ("two_users_box", [], "no loop of chapters 3 to 6: its run has a spectral radius of 0.9"),
        ("single_axis_distributed", ["channels.lan.loss=0.1"], "lan.forward has loss"),
        ("single_axis_distributed", ["channels.lan.jitter=1"], "lan.forward has jitter"),
    ],
)
def test_another_loop_is_refused(name: str, sets: list[str], said: str) -> None:
    written = read(name, (), sets)
    with pytest.raises(InputError, match=said):
        refuse_another_loop(written, read_loop(written.built()))


def test_the_commands_ask() -> None:
    done = CliRunner().invoke(
        command, ["--scenario", "single_axis_distributed", "--set", "channels.lan.loss=0.1"]
    )
    assert isinstance(done.exception, InputError)
    assert "lan.forward has loss" in str(done.exception)
