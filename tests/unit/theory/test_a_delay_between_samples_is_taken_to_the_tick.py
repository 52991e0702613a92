"""The closed form of a delay between two samples is the run's: packets count when they are heard.

At whole ratios and others, both architectures, any number of ticks there and back: the radius and
the compensation that nulls what a user feels are those of the kernel's own map.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.answers.felt import null_run_damping
from cosim.analysis.answers.push import find_push
from cosim.analysis.single_axis import read_single_axis
from cosim.base.errors import InputError
from cosim.scenario.load import read
from cosim.theory.chance.mean_square import critical_loss
from cosim.theory.models.monodromy import monodromy
from cosim.theory.models.parameters import Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability
from cosim.theory.transparency.compensation import null_compensation

ARCHITECTURES = ("distributed", "centralized")


def written(architecture: str, ticks: tuple[int, int], sets: list[str]):
    delay = f"channels.lan.delay={{forward: {ticks[0]} ticks, backward: {ticks[1]} ticks}}"
    name = f"single_axis_{architecture}"
    return read(name, (), [*sets, "channels.lan.round_trip_delay=~", delay])


def closed(scenario) -> tuple[Parameters, Timing]:
    loop = read_single_axis(scenario)
    channel = scenario.channels["lan"]
    ways = [
        Fraction(way.delay.ticks, channel.period) for way in (channel.forward, channel.backward)
    ]
    if loop.architecture == "centralized" and channel.between[0] == "station_1":
        ways.reverse()
    return Parameters(loop.architecture, loop.values, {}, loop.users), loop.timing.delayed(*ways)


@pytest.mark.parametrize("architecture", ARCHITECTURES)
@pytest.mark.parametrize("sets", [[], ["rates.network=96 Hz"], ["base_rate=3072 Hz"]])
def test_the_radius_is_that_of_the_run(architecture: str, sets: list[str]) -> None:
    generator = np.random.default_rng(len(sets) + len(architecture))
    for _ in range(4):
        ticks = tuple(int(n) for n in generator.integers(0, 40, 2))
        run = written(architecture, ticks, sets)
        parameters, timing = closed(run.built())
        with ask(run) as asked:
            found = asked.point().spectrum().radius
        assert stability(parameters.model(), timing).spectral_radius == pytest.approx(
            found, abs=1e-10
        )


@pytest.mark.parametrize("architecture", ARCHITECTURES)
def test_the_compensation_is_that_of_the_run(architecture: str) -> None:
    run = written(architecture, (6, 3), [])
    parameters, timing = closed(run.built())
    user = int(architecture == "centralized")
    with ask(run) as asked:
        found = null_run_damping(asked, find_push(asked.scenario, f"hand_{user + 1}"))
    nulled = null_compensation(parameters.model(), timing, user)
    assert nulled.value == pytest.approx(found.value, abs=1e-9)
    assert nulled.compensated.spectral_radius == pytest.approx(found.radius, abs=1e-9)


def test_a_line_between_whole_samples_is_another_number() -> None:
    """It errs by a percent, which is why it is not taken."""

    def null(ticks: int) -> float:
        parameters, timing = closed(written("distributed", (ticks, 0), []).built())
        return null_compensation(parameters.model(), timing, 0).value

    line = 0.25 * null(0) + 0.75 * null(8)
    assert 0.005 < abs(line / null(6) - 1.0) < 0.02


def test_what_needs_whole_samples_refuses_a_delay_between_two() -> None:
    parameters, timing = closed(written("distributed", (6, 0), []).built())
    for ask_for in (critical_loss, monodromy):
        with pytest.raises(InputError, match="between two network samples"):
            ask_for(parameters.model(), timing)


def test_ticks_of_a_whole_sample_are_one() -> None:
    timing = Timing().delayed(Fraction(17, 8), Fraction(63, 64))
    assert timing.delay == PathDelay(2, 1, 1, 0)
    assert replace(timing, delay=PathDelay(2, 1)).has_frame
    with pytest.raises(InputError, match="cannot be negative"):
        PathDelay(0, 0, -1)
