"""The map of the real kernel and the closed forms of chapters 3 to 6, derived apart, agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from cosim.analysis.answers.asked import AskedRun, ask
from cosim.analysis.single_axis import read_single_axis
from cosim.scenario.load import read
from cosim.theory.models.assembly import assemble
from cosim.theory.models.direct import direct_model
from cosim.theory.models.parameters import Parameters
from cosim.theory.stability.spectral_radius import stability
from fmus.builder import load_model


def random_sets(generator: np.random.Generator, name: str) -> list[str]:
    """Gains, masses, rates, delays, walls and computation delays of a scenario at random."""

    def number(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))

    couplers = {
        "single_user": ("coupler_1",),
        "single_axis_centralized": ("coupler_1", "coupler_2"),
        "single_axis_distributed": (
            *("coupler_11", "coupler_12", "coupler_o1"),
            *("coupler_22", "coupler_21", "coupler_o2"),
        ),
    }[name]
    distributed = name == "single_axis_distributed"
    bodies = ("object_1", "object_2") if distributed else ("object",)
    hands = ("hand_1",) if name == "single_user" else ("hand_1", "hand_2")
    late = int(generator.integers(0, 3)) if generator.random() < 0.3 else 0
    sets = [f"components.{c}.parameters.stiffness={number(10, 5000)}" for c in couplers]
    sets += [f"components.{c}.parameters.damping={number(0.3, 20)}" for c in couplers]
    sets += [f"components.{c}.parameters.computation_delay_ticks={late}" for c in couplers]
    sets += [f"components.{body}.parameters.mass={number(0.05, 2)}" for body in (*bodies, *hands)]
    sets += [f"components.{b}.parameters.compensation={generator.uniform(-2, 2)}" for b in bodies]
    if generator.random() < 0.3 and not late:
        wall = number(100, 1e5)
        sets += [f"components.{body}.parameters.wall_stiffness={wall}" for body in bodies]
    rate = int(generator.choice([256, 512, 1024, 2048]))
    sets.append(f"rates.control={rate} Hz")
    if name != "single_user":
        network = rate // int(generator.choice([1, 2, 4, 8]))
        sets.append(f"rates.network={network} Hz")
        sets.append(f"channels.lan.round_trip_delay={int(generator.integers(0, 7))}")
    return sets


def closed_radius(asked: AskedRun) -> tuple[float, float]:
    """The radius of the closed form, and the condition of the eigenvalue that decides."""
    loop = read_single_axis(asked.scenario)
    model = Parameters(loop.architecture, loop.values, {}, loop.users).model()
    found = stability(model, loop.timing)
    if loop.timing.ratio.denominator == 1:
        matrix = assemble(model, loop.timing).frame().map
    else:
        matrix = direct_model(model, loop.timing).lifted.map
    return found.spectral_radius, condition(matrix, found.spectrum.values[0])


def condition(matrix: np.ndarray, value: complex) -> float:
    values, right = np.linalg.eig(matrix)
    left = np.linalg.pinv(right)
    number = int(np.argmin(np.abs(values - value)))
    return float(np.linalg.norm(left[number]) * np.linalg.norm(right[:, number]))


NAMES = ("single_user", "single_axis_centralized", "single_axis_distributed")


@pytest.mark.parametrize("batch", range(10))
def test_one_axis_runs_have_the_radius_of_the_closed_form(batch: int) -> None:
    generator = np.random.default_rng(batch)
    for number in range(10):
        name = NAMES[number % 3] if number % 4 else NAMES[2]
        with ask(read(name, (), random_sets(generator, name))) as asked:
            found = asked.point().spectrum()
            wanted, sensitivity = closed_radius(asked)
            apart = abs(found.radius - wanted) / max(wanted, 1.0)
            assert apart <= 1e-9 * max(1.0, 1e-3 * sensitivity), asked.written.root
            assert found.stable == (wanted < 1.0 - 1e-12)


@pytest.mark.parametrize("rate", [96, 160, 192, 1536])
@pytest.mark.parametrize("name", NAMES[1:])
def test_between_two_control_ticks_the_last_one_is_sent(name: str, rate: int) -> None:
    """Ratios that are not whole; sampling the bodies right then is another loop."""
    sets = [f"rates.network={rate} Hz", "channels.lan.round_trip_delay=1"]
    with ask(read(name, (), sets)) as asked:
        found = asked.point().spectrum().radius
        loop = read_single_axis(asked.scenario)
        model = Parameters(loop.architecture, loop.values, {}, loop.users).model()
        assert stability(model, loop.timing).spectral_radius == pytest.approx(found, abs=1e-10)
        other = stability(model, replace(loop.timing, sampling="between_ticks")).spectral_radius
        assert abs(other - found) > 1e-5


def test_an_object_takes_the_forces_of_nine_users() -> None:
    forces = next(v for v in load_model("object").variables if v.name == "force")
    assert forces.size == 2 * 9 - 1
