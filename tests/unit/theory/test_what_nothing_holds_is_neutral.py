"""A motion that nothing holds is no instability, and no stability either."""

from __future__ import annotations

import json

import pytest
from click.testing import CliRunner

from cosim.base.errors import InputError
from cosim.cli import cli

TURNING = ("--scenario", "thesis/turning")
"""The hands that hold the box have no stiffness along x; user b stands apart."""
HELD = tuple(
    word
    for hand in ("operator_a1", "operator_a2")
    for word in ("--set", f"components.{hand}.parameters.stiffness=[100, 2000]")
)


@pytest.mark.parametrize(("further", "verdict"), [((), "neutral"), (HELD, "stable")])
def test_a_grasp_by_hands_without_stiffness_is_neutral(
    further: tuple[str, ...], verdict: str
) -> None:
    done = CliRunner().invoke(cli, ["theory", "radius", *TURNING, *further, "--json"])
    found = json.loads(done.stdout)
    assert found["verdict"] == verdict
    assert found["stable"] == (verdict == "stable")


def test_it_has_no_margins_and_the_sentence_does_not_call_it_unstable() -> None:
    done = CliRunner().invoke(cli, ["theory", "margins", *TURNING])
    assert isinstance(done.exception, InputError)
    assert "neither decays nor grows" in str(done.exception)


def test_what_grows_is_unstable() -> None:
    grows = ("single_axis_centralized", "--set", "k_2=2000", "--json")
    done = CliRunner().invoke(cli, ["theory", "radius", "--scenario", *grows])
    assert json.loads(done.stdout)["verdict"] == "unstable"
