"""Whatever is changed in a planar scenario, the theory answers for that run, or refuses by name.

The run is pushed a little in every one of its numbers at once and left alone; after each of four
hyperperiods it is where the powers of its own map say, and not where those of the scenario before
it was changed do.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from cosim.analysis.answers.asked import ask
from cosim.analysis.monodromy.blocks import connected_blocks, dropped
from cosim.base.errors import InputError
from cosim.scenario.load import read
from tests.support.theory.continued import pushed
from tests.support.theory.mutations import PLANAR, planar_mutations

PERIODS = 4
SHARE = 0.03
"""Of the step of each coordinate: 0.3 µm, 0.3 µN."""
CLOSE = 1e-5
AT = Fraction(10)
"""Where both scenarios end, and rest (s)."""
WAY = (
    "components.way={fmu: signal, station: station_a, rate: control, parameters: "
    "{mode: constant, amplitude: 100}}"
)
OPERATORS = [f"components.operator_{finger}" for finger in ("a1", "a2", "b1", "b2")]


@cache
def base(name: str) -> np.ndarray:
    with ask(read(name), at=AT) as asked:
        return asked.point().matrix


def apart(matrix: np.ndarray, push: np.ndarray, seen: np.ndarray, size: np.ndarray) -> float:
    """How far the run is from the powers of a map, of what it moves by in each hyperperiod.

    In the numbers that decide: what is carried and never read (a wave beside plain forces) may have
    a memory of its own.
    """
    deciding = connected_blocks([matrix], ~dropped([matrix]))[0]
    worst, expected = 0.0, push
    for row in seen:
        expected = matrix @ expected
        scale = np.max(np.abs(row[deciding]) / size[deciding])
        off = np.max(np.abs(row - expected)[deciding] / size[deciding])
        worst = max(worst, float(off / scale))
    return worst


def differs(one: np.ndarray, other: np.ndarray, size: np.ndarray) -> bool:
    """By more than the operating point's own place makes of it."""
    return float(np.max(np.abs(one - other) * size[None, :] / size[:, None])) > 1e-2


def check(name: str, sets: list[str], seed: int) -> bool:
    """Whether it was answered for; an answer is held against the run."""
    with ask(read(name, (), sets), at=AT) as asked:
        try:
            point = asked.point()
        except InputError:  # by name, which is an answer as well
            return False
        run = point.run
        size = run.steps
        push = SHARE * size * np.random.default_rng(seed).uniform(-1, 1, run.size)
        seen = pushed(run, push, PERIODS)
        own = apart(point.matrix, push, seen, size)
        assert own < CLOSE, (name, sets, own)
        before = base(name)
        if before.shape == point.matrix.shape and differs(before, point.matrix, size):
            assert apart(before, push, seen, size) > 10 * own, (name, sets)
    return True


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANAR)
def test_a_run_as_it_is_bundled_follows_the_powers_of_its_map(name: str) -> None:
    assert check(name, [], 0)


@pytest.mark.one_in(40)
@pytest.mark.parametrize("batch", range(40))
def test_a_mutated_planar_run_follows_the_powers_of_its_own_map(batch: int) -> None:
    generator = np.random.default_rng(500 + batch)
    answered = 0
    for number in range(5):
        name = sorted(PLANAR)[(batch + number) % 2]
        sets = planar_mutations(generator, name)
        answered += check(name, sets, number)
    assert answered >= 1


@pytest.mark.slow
def test_a_map_that_ignores_a_change_is_found_out() -> None:
    """The comparison itself must fail for the map of the scenario before it was changed."""
    name, sets = "two_users_box", ["components.vr_a.parameters.coupling_stiffness=78"]
    with ask(read(name, (), sets)) as asked:
        point = asked.point()
        push = SHARE * point.run.steps * np.random.default_rng(1).uniform(-1, 1, point.run.size)
        seen = pushed(point.run, push, PERIODS)
        assert apart(point.matrix, push, seen, point.run.steps) < CLOSE
        assert apart(base(name), push, seen, point.run.steps) > CLOSE


@pytest.mark.parametrize(
    ("sets", "said"),
    [
        (["components.vr_a.parameters.passivity=time_domain"], "vr_a has a passivity controller"),
        (["components.vr_b.parameters.deadband=0.1"], "vr_b has a deadband"),
        (["components.vr_a.parameters.predictor=intent"], "vr_a guesses what hands intend"),
        (
            [
                "channels.lan={between: [station_a, station_b], rate: network, trace: [1, 2]}",
            ],
            "lan.forward has trace",
        ),
        (
            [
                "knobs={vr_a.coupling_stiffness: {minimum: 0, maximum: 500}}",
                WAY,
                "connections.0={from: way.value, to: vr_a.coupling_stiffness, unit: ignore}",
            ],
            "turns a parameter",
        ),
    ],
)
def test_what_has_no_map_is_refused_by_name(sets: list[str], said: str) -> None:
    with ask(read("two_users_box", (), sets)) as asked, pytest.raises(InputError, match=said):
        asked.point()


@pytest.mark.slow
def test_each_change_of_the_network_has_its_own_radius() -> None:
    """Seven of eight ticks are neither none nor one sample; prediction is not holding."""

    def radius(*sets: str) -> float:
        with ask(read("two_users_box", (), sets)) as asked:
            return asked.point().spectrum().radius

    clear = "channels.lan.round_trip_delay=~"
    ways = [
        ["channels.lan.round_trip_delay=0"],
        [clear, "channels.lan.each_way_delay='7 ticks'"],
        ["components.vr_a.parameters.predictor=linear"],
    ]
    found = [radius(*sets) for sets in ways]
    assert len({round(value, 7) for value in found}) == len(found)


@pytest.mark.parametrize(
    "sets",
    [
        [],
        [
            "components.operator_a1.flavour=fmi3-arrays",
            "components.operator_a2.flavour=fmi3-arrays",
        ],
        [
            f"components.operator_{f}.parameters.impedance=grip_2_newton"
            for f in ("a1", "a2", "b1", "b2")
        ],
    ],
    ids=["scalars", "arrays", "grips"],
)
def test_a_moment_at_which_users_carry_is_refused(sets: list[str]) -> None:
    with (
        ask(read("two_users_box", (), sets), at=Fraction(13, 4)) as asked,
        pytest.raises(InputError, match=r"operator_\w+.reference_\w+\[1\].* changes with time"),
    ):
        asked.point()


@pytest.mark.slow
def test_a_point_near_one_of_another_plan_is_looked_for_anew() -> None:
    """Along a delay or a rate the state of the run before does not fit into the next."""
    clear = "channels.lan.round_trip_delay=~"
    for sets in ([clear, "channels.lan.each_way_delay='7 ticks'"],):
        with ask(read("two_users_box")) as near, ask(read("two_users_box", (), sets)) as alone:
            wanted = alone.point().spectrum().radius
            near.point()
            assert near.point(sets).spectrum().radius == pytest.approx(wanted, abs=1e-7)


@pytest.mark.slow
def test_the_order_of_connections_does_not_count() -> None:
    wires = read("two_users_box").built().connections
    turned = "connections=[" + ", ".join(f"'{wire}'" for wire in reversed(wires)) + "]"
    written = read("two_users_box", (), ["connections=~", turned])
    assert written.built().connections == tuple(reversed(wires))
    with ask(written) as other, ask(read("two_users_box")) as asked:
        assert other.point().spectrum().radius == pytest.approx(
            asked.point().spectrum().radius, abs=1e-9
        )
