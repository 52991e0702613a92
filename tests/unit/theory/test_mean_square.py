"""Mean-square stability: against Monte Carlo, fixed delays, and the full Kronecker form."""

from __future__ import annotations

import numpy as np
import pytest

from cosim.base.errors import InputError
from cosim.theory.chance.mean_square import (
    JumpSystem,
    critical_loss,
    jump_system,
    mean_square_radius,
)
from cosim.theory.chance.packets import (
    Losses,
    bernoulli,
    gilbert_elliott,
    independent_frames,
    join,
    random_delay,
)
from cosim.theory.models.assembly import assemble
from cosim.theory.models.frame import HOLD
from cosim.theory.models.mass_spring_damper import Model
from cosim.theory.models.parameters import CHAPTER_5, Architecture, Parameters
from cosim.theory.models.timing import PathDelay, Timing
from cosim.theory.stability.spectral_radius import stability


def loop(architecture: Architecture = "distributed", **given: float) -> Model:
    return Parameters(architecture, given, CHAPTER_5[architecture]).model()


def system(loss: float, losses: Losses = "independent") -> JumpSystem:
    assembly = assemble(loop(), Timing(delay=PathDelay.round_trip(1)))
    processes = [bernoulli(loss, link.delay) for link in assembly.links]
    return jump_system(assembly, join(processes, losses))


@pytest.mark.parametrize("loss", [0.1, 0.4])
def test_monte_carlo_second_moment_matches(loss: float) -> None:
    """Simulated with losses drawn frame by frame, E[x xᵀ] follows the theory within 1 %."""
    found = system(loss)
    rng = np.random.default_rng(5)
    n, runs, frames = found.maps.shape[1], 200_000, 8
    start = rng.normal(size=n)
    states = np.tile(start, (runs, 1))
    outcomes = found.pattern.outcomes
    for _ in range(frames):
        lost = rng.random((runs, 2)) < loss
        for number, outcome in enumerate(outcomes):
            chosen = np.all(lost == [event == HOLD for event in outcome], axis=1)
            states[chosen] = states[chosen] @ found.maps[number].T
    moment = np.outer(start, start)[None]
    for _ in range(frames):
        moment = np.einsum(
            "e,eab,bc,edc->ad", found.pattern.emission[0], found.maps, moment[0], found.maps
        )[None]
    simulated = states.T @ states / runs
    assert np.trace(simulated) == pytest.approx(np.trace(moment[0]), rel=0.01)
    assert np.linalg.norm(simulated - moment[0]) < 0.01 * np.linalg.norm(moment[0])


def test_reduced_second_moment_has_the_radius_of_the_full_kronecker_form() -> None:
    found = system(0.3)
    weights = found.pattern.emission[0]
    full = sum(w * np.kron(m, m) for w, m in zip(weights, found.maps, strict=True))
    assert found.mean_square_radius() == pytest.approx(
        float(np.max(np.abs(np.linalg.eigvals(full)))), rel=1e-9
    )


def test_markov_channel_has_the_radius_of_the_full_kronecker_form() -> None:
    assembly = assemble(loop(), Timing())
    processes = [gilbert_elliott(0.1, 0.4, link.delay) for link in assembly.links]
    found = jump_system(assembly, join(processes, "together"))
    n = found.maps.shape[1] ** 2
    P = found.pattern.transition
    blocks = np.zeros((2 * n, 2 * n))
    for mode in range(2):
        squares = sum(
            w * np.kron(m, m) for w, m in zip(found.pattern.emission[mode], found.maps, strict=True)
        )
        for before in range(2):
            blocks[mode * n : (mode + 1) * n, before * n : (before + 1) * n] = (
                P[before, mode] * squares
            )
    assert found.mean_square_radius() == pytest.approx(
        float(np.max(np.abs(np.linalg.eigvals(blocks)))), rel=1e-9
    )


@pytest.mark.parametrize("architecture", ["centralized", "distributed"])
@pytest.mark.parametrize("n", range(4))
def test_without_loss_it_is_the_spectral_radius_squared(architecture: Architecture, n: int) -> None:
    model, timing = loop(architecture), Timing(delay=PathDelay.round_trip(n))
    radius = mean_square_radius(model, timing, lambda delay: bernoulli(0.0, delay))
    assert radius == pytest.approx(stability(model, timing).spectral_radius ** 2, rel=1e-9)


@pytest.mark.parametrize("delay", [0, 1, 2])
def test_a_certain_random_delay_is_a_fixed_one(delay: int) -> None:
    model = loop()
    certain = [0.0] * delay + [1.0]
    radius = mean_square_radius(model, Timing(), lambda _: random_delay(certain))
    fixed = stability(model, Timing(delay=PathDelay.each_way(delay))).spectral_radius
    assert radius == pytest.approx(fixed**2, rel=1e-9)


def test_bursts_of_independent_packets_are_bernoulli() -> None:
    model, timing = loop(), Timing()
    burst = mean_square_radius(model, timing, lambda d: gilbert_elliott(0.2, 0.8, d))
    assert burst == pytest.approx(mean_square_radius(model, timing, lambda d: bernoulli(0.2, d)))


def test_age_of_the_freshest_packet_matches_a_simulation_of_single_packets() -> None:
    """Packets with their own delays and losses, the freshest held: how old it is, how often."""
    process = random_delay([0.2, 0.5, 0.3], loss=0.1)
    share = independent_frames(process).emission[0]
    rng = np.random.default_rng(1)
    frames = 200_000
    delays = rng.choice([0, 1, 2, 10**9], p=[0.18, 0.45, 0.27, 0.1], size=frames)
    arrivals: dict[int, int] = {}
    held, counts = -(10**6), np.zeros(4)
    for sent, delay in enumerate(delays):
        if delay < frames:
            due = sent + int(delay)
            arrivals[due] = max(sent, arrivals.get(due, -1))
        held = max(held, arrivals.pop(sent, -1))
        counts[min(sent - held, 3)] += 1
    assert np.allclose(counts / frames, share, atol=0.005)
    assert process.events == (0, 1, 2, HOLD)


def test_critical_loss_is_where_the_radius_crosses_one() -> None:
    model, timing = loop("centralized"), Timing()
    critical = critical_loss(model, timing)
    assert critical is not None
    for loss, stable in ((critical - 1e-4, True), (critical + 1e-4, False)):
        radius = mean_square_radius(model, timing, lambda d, p=loss: bernoulli(p, d))
        assert (radius < 1) == stable


def test_critical_loss_of_loops_that_are_unstable_or_immune() -> None:
    assert critical_loss(loop("centralized"), Timing(delay=PathDelay.round_trip(2))) == 0.0
    assert critical_loss(loop(), Timing()) is None


def test_what_is_no_probability_is_refused() -> None:
    with pytest.raises(InputError, match="between 0 and 1"):
        bernoulli(1.2, 0)
    with pytest.raises(InputError, match="negative"):
        random_delay([-0.1, 1.1])
