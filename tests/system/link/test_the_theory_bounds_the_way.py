"""How long packets may take and still count is what the scenario's theory calls stable."""

from __future__ import annotations

from dataclasses import replace

import pytest

from cosim.analysis.longest_delay import longest_delay
from cosim.analysis.loop import read_loop
from cosim.link.stream.form import LONGEST_DELAY
from cosim.master.assembly.assemble import put_together
from cosim.scenario import load
from cosim.station.run import _bound_delays
from cosim.station.split import split
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import PathDelay
from cosim.theory.stability.spectral_radius import stability


@pytest.mark.parametrize("name", ["two_users_box", "single_axis_distributed", "thesis/three_users"])
def test_one_sample_more_is_unstable(name: str) -> None:
    scenario = load(name, (), ())
    found = longest_delay(scenario)
    assert found is not None
    assert found.bounded
    loop = read_loop(scenario)
    model = Parameters(loop.architecture, loop.values, {}, users=loop.users).model()
    for samples, stable in ((found.samples, True), (found.samples + 1, False)):
        timing = replace(loop.timing, delay=PathDelay.each_way(samples))
        assert stability(model, timing).stable is stable


def bounds(*sets: str, theory=longest_delay) -> tuple[list[int], list[str]]:
    scenario = load("two_users_box", (), sets)
    half = split(put_together(scenario), "station_a")
    said: list[str] = []
    _bound_delays(half, scenario, theory, said.append)
    return [setting.longest_delay for peer in half.peers for setting in peer.settings], said


def test_a_station_takes_the_bound_from_the_theory_and_says_so() -> None:
    found = longest_delay(load("two_users_box", (), ()))
    lengths, said = bounds()
    assert lengths == [found.samples]
    assert said == [
        f"the theory allows {found.samples} samples of delay each way: longer ways do not count"
    ]


def test_what_the_scenario_says_is_not_asked_again() -> None:
    assert bounds("link.max_delay=3") == ([3], [])
    assert bounds("link.max_delay=5", "link.delay=3") == ([5], [])


def test_a_delay_that_the_theory_calls_unstable_is_said() -> None:
    allowed = bounds()[0][0]
    lengths, said = bounds(f"link.delay={allowed + 1}")
    assert lengths == [allowed + 1]
    assert said[1:] == [
        f"delay: {allowed + 1} is longer than that, so the theory calls this loop unstable"
    ]


def test_a_loop_that_no_chapter_knows_has_the_stated_bound() -> None:
    lengths, said = bounds(theory=lambda _: None)
    assert lengths == [LONGEST_DELAY]
    assert "say max_delay under link:" in said[0]
