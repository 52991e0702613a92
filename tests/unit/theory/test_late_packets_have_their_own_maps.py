"""Jitter, reordering and loss: the map of each fate is what the kernel does to such packets.

Limits, set beforehand: closed forms 1e-9; a run of given delays 1e-9 of its size; the growth of
second moments over many runs within four standard errors and 2 % of what the maps predict.
"""

from __future__ import annotations

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.answers.chance import own_chance, with_losses
from cosim.analysis.answers.vary import deciding_radius
from cosim.analysis.chance.chain import chain_of
from cosim.analysis.chance.delays import PacketDelays
from cosim.analysis.monodromy.refusal import refuse_chance
from cosim.analysis.monodromy.run_map import RunMap
from cosim.analysis.single_axis import read_single_axis
from cosim.base.errors import InputError
from cosim.master.run.simulation import assemble
from cosim.scenario.load import read
from cosim.theory.chance.mean_square import mean_square_radius
from cosim.theory.chance.packets import random_delay
from cosim.theory.models.parameters import Parameters

STILL = ["components.step_1.parameters.amplitude=0"]
DISTRIBUTED, CENTRALIZED = "single_axis_distributed", "single_axis_centralized"


@pytest.mark.parametrize(
    ("name", "sets", "weights", "loss"),
    [
        (CENTRALIZED, ["channels.lan.jitter=1"], [0.5, 0.5], 0.0),
        (CENTRALIZED, ["channels.lan.jitter=1", "channels.lan.loss=0.3"], [0.5, 0.5], 0.3),
        (CENTRALIZED, ["channels.lan.reorder=0.2"], [0.8, 0.0, 0.2], 0.0),
        (DISTRIBUTED, ["channels.lan.jitter={weights: [0.7, 0.3]}"], [0.7, 0.3], 0.0),
    ],
)
def test_whole_samples_have_the_radius_of_the_closed_form(
    name: str, sets: list[str], weights: list[float], loss: float
) -> None:
    with ask(read(name, (), sets)) as asked:
        point = asked.point()
        chance = own_chance(point)
        assert chance is not None
        loop = read_single_axis(read(name).built())
        model = Parameters(loop.architecture, loop.values, {}, loop.users).model()
        wanted = mean_square_radius(
            model, loop.timing, lambda delay: random_delay([0.0] * delay + weights, loss)
        )
        assert chance.radius() == pytest.approx(wanted, abs=1e-9)


def arrivals(delays: list[int], period: int, number: int) -> list[tuple[int, int]]:
    """Which packets of the past become what is held in a period, by definition."""
    held = -1
    for tick in range(number * period):
        held = max(held, *(p for p in range(number) if p * period + delays[p] <= tick), -1)
    found: list[tuple[int, int]] = []
    for offset in range(period):
        tick = number * period + offset
        newest = max((p for p in range(number + 1) if p * period + delays[p] <= tick), default=-1)
        if newest > held:
            found.append((offset, number - newest))
            held = newest
    return found


@pytest.mark.parametrize(
    "ticks",
    [
        [0, 8],
        pytest.param([3, 5, 12], marks=pytest.mark.slow),
        pytest.param([0, 1, 7, 9], marks=pytest.mark.exhaustive),
    ],
)
def test_the_product_of_maps_is_the_run_of_those_delays(ticks: list[int]) -> None:
    """The kernel with a trace of given delays ends where the maps of their fates lead."""
    generator = np.random.default_rng(len(ticks))
    periods = 24
    ways = {way: generator.choice(ticks, periods + 1).tolist() for way in ("forward", "backward")}
    # The first packets have the longest delay, so that both begin with the same in flight.
    start = 8
    for delays in ways.values():
        delays[:start] = [max(ticks)] * start
    traces = ", ".join(
        f"{way}: [{', '.join(f'{d} ticks' for d in delays)}]" for way, delays in ways.items()
    )
    kicked = ["components.object_1.parameters.initial_velocity=0.3", *STILL]
    weights = [1.0 if n in ticks else 0.0 for n in range(max(ticks) + 1)]
    total = sum(weights)
    jitter = [w / total for w in weights]
    jittered = [
        "channels.lan.round_trip_delay=0",
        f"channels.lan.jitter={{weights: {jitter}, step: 1 tick}}",
        *kicked,
    ]
    traced = [
        "channels.lan={between: [station_1, station_2], rate: network, trace: {" + traces + "}}",
        *kicked,
    ]
    with (
        ask(read(DISTRIBUTED, (), jittered)) as asked,
        assemble(read(DISTRIBUTED, (), traced).built()) as real,
    ):
        chance = own_chance(asked.point())
        assert chance is not None
        place = {
            tuple(fate.arrivals for fate in outcome): number
            for number, outcome in enumerate(chance.maps.outcomes)
        }
        real.start(real.scenario.ticks)
        period = asked.point().run.hyperperiod
        real.advance(start * period)
        run = RunMap(real)
        # The theory's list in flight is that of the longest delay; here it is the same at first.
        state = run.start
        assert state.size == asked.point().run.size
        bundles = [b.bundle.name for b in asked.point().run.bundles if b.bundle.channel]
        ends = {name: ways[name.rsplit(".", 1)[1]] for name in bundles}
        for number in range(start, periods):
            key = tuple(tuple(arrivals(ends[name], period, number)) for name in bundles)
            state = chance.maps.maps[place[key]] @ state
        real.advance(periods * period)
        after = RunMap(real)
        count = sum(each.values.size for each in after.fmus.values())
        size = np.abs(state[:count]).max()
        assert np.abs(after.start[:count] - state[:count]).max() < 1e-9 * size


def test_a_chain_is_of_probabilities_and_forgets_nothing() -> None:
    packets = PacketDelays({0: 0.2, 5: 0.3, 11: 0.5}, 8, 0.1)
    chain = chain_of([packets], "independent")
    leaving = np.zeros(chain.modes)
    for step in chain.steps:
        leaving[step.source] += step.probability
        offsets = [offset for offset, _ in step.fates[0].arrivals]
        ages = [age for _, age in step.fates[0].arrivals]
        assert offsets == sorted(set(offsets))
        assert ages == sorted(set(ages), reverse=True)
    np.testing.assert_allclose(leaving, 1.0, atol=1e-12)


def growth(sets: list[str], name: str, seeds: int, periods: tuple[int, int]) -> tuple[float, float]:
    """The growth of E|x|² a period over seeded runs, and its standard error (from groups)."""
    from cosim.base.recording import MemorySink

    bodies = ["hand_1", "hand_2"]
    record = f"record=[{', '.join(f'{body}.velocity' for body in bodies)}]"
    early, late = np.zeros(seeds), np.zeros(seeds)
    length = f"duration={(periods[1] + 12) / 128} s"
    written = read(name, (), [*sets, *STILL, record, length])
    for seed in range(seeds):
        sink = MemorySink()
        with assemble(written.changed([f"seed={seed}"]).built()) as run:
            run.run(sink)
        rows = np.column_stack([sink.signal(f"{body}.velocity") for body in bodies])[::8]
        size = (rows**2).sum(axis=1)
        early[seed], late[seed] = size[periods[0] :][:8].mean(), size[periods[1] :][:8].mean()
    span = periods[1] - periods[0]
    whole = (late.mean() / early.mean()) ** (1 / span)
    groups = [(late[g::10].mean() / early[g::10].mean()) ** (1 / span) for g in range(10)]
    return float(whole), float(np.std(groups) / np.sqrt(10))


MONTE_CARLO = [
    "channels.lan.jitter=2",
    "channels.lan.loss=0.2",
    "components.object.parameters.initial_velocity=0.3",
    "components.coupler_2.parameters.stiffness=1500",
]


@pytest.mark.slow
def test_second_moments_grow_in_the_simulation_as_the_maps_say() -> None:
    with ask(read(CENTRALIZED, (), [*MONTE_CARLO, *STILL])) as asked:
        chance = own_chance(asked.point())
        assert chance is not None
        predicted = chance.radius()
        alone = asked.point().spectrum().radius ** 2
    found, error = growth(MONTE_CARLO, CENTRALIZED, 200, (60, 100))
    assert abs(found - predicted) < min(4 * error, 0.02 * predicted), (found, predicted, error)
    assert abs(alone - predicted) > 0.02  # one fixed delay would not do


def test_what_is_one_maps_is_refused_where_packets_draw_their_fates() -> None:
    for key, value in (("loss", "0.1"), ("jitter", "1"), ("reorder", "0.1")):
        scenario = read(DISTRIBUTED, (), [f"channels.lan.{key}={value}"]).built()
        with pytest.raises(InputError, match=f"lan.forward has {key}.*modes are of one"):
            refuse_chance(scenario, "modes are")
    refuse_chance(read(DISTRIBUTED, (), ["channels.lan.duplication=0.1"]).built(), "modes are")


def test_bursts_with_jitter_and_recorded_delays_are_refused_by_name() -> None:
    bursts = "channels.lan.loss={good_to_bad: 0.1, bad_to_good: 0.5}"
    for sets, said in (
        ([bursts, "channels.lan.jitter=1"], "loses packets in bursts and delays each"),
        (["channels.lan={between: [station_1, station_2], rate: network, trace: [1, 2]}"], "trace"),
    ):
        with ask(read(DISTRIBUTED, (), sets)) as asked, pytest.raises(InputError, match=said):
            own_chance(asked.point())


def test_delays_that_alternate_are_refused_before_a_map_is_taken() -> None:
    with (
        ask(read("thesis/alternating_delays")) as asked,
        pytest.raises(InputError, match=r"alternating_delays.yaml:\d+:\d+: lan.forward has trace"),
    ):
        asked.point()


def test_the_critical_loss_knows_the_jitter() -> None:
    found: list[float] = []
    for sets in ([], ["channels.lan.jitter=1"]):
        with ask(read(CENTRALIZED, (), sets)) as asked:
            critical = with_losses(asked.point()).critical_loss()
            assert critical is not None
            found.append(critical)
    assert found[1] < 0.9 * found[0]


@pytest.mark.parametrize(
    ("bursts", "loss"),
    [
        ("{good_to_bad: 0, bad_to_good: 0.001}", 0.0),
        ("{good_to_bad: 0, bad_to_good: 0.001, loss_good: 0.2}", 0.2),
        ("{good_to_bad: 0.001, bad_to_good: 0, loss_good: 0, loss_bad: 0.3}", 0.3),
    ],
)
def test_bursts_that_never_begin_or_end_are_no_bursts(bursts: str, loss: float) -> None:
    """A channel is in the state that it stays in, and the other one says nothing of it."""

    def radius(loss: str) -> float:
        with ask(read("single_axis_distributed", (), [f"channels.lan.loss={loss}"])) as asked:
            return deciding_radius(asked.point())

    assert radius(bursts) == pytest.approx(radius(str(loss)), rel=1e-9)
